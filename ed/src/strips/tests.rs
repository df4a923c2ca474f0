//! Internal tests of strips: windows that go wrong, strips that stay, boundaries that move.

use stosszahl_model::EachCollision;
use stosszahl_model::samples::{EqualDisks, law};

use super::*;
use crate::disk::tests::lattice;
use crate::{Buckets, DissipationRule};

type Lattice = EventDrivenEngine<EqualDisks, Buckets>;

/// Number of collisions in a window.
const EACH: f64 = 10_000.0;

/// Creates a gas that cools with a contact time, on a lattice with this many disks in each row and
/// column.
fn cooling(side: u32) -> Lattice {
    let mut elastic = lattice::<Buckets>(side);
    elastic.scene.restitution = law(0.8);
    let mut start = elastic.checkpoint();
    start.image_flags = vec![[0; 2]; elastic.names.len()];
    let contact_time = DissipationRule::ContactTime(0.1);
    EventDrivenEngine::new(elastic.scene, contact_time, start).expect("an engine")
}

/// Windows so long that many are wrong, after others that were right, leave no trace: the gas
/// returns to these and observers see each collision once. Many low strips become fewer, whose
/// halos are wider. All that a checkpoint has is that of one engine, counts of candidates and
/// elastic contacts too.
#[test]
fn wrong_windows_leave_no_trace() {
    let (mut windows, mut retries, mut fewer) = (0, 0, false);
    for start in 0..4 {
        let mut run = |strips: usize| {
            let mut engine = cooling(100);
            let disordered = engine.advance(f64::INFINITY, 20_000 + 1_000 * start, &mut ());
            assert!(!disordered.expect("time"));
            let mut engine = StripedEngine::new(engine, strips);
            let mut seen = Vec::new();
            let mut observer = EachCollision(|collision: &Collision| seen.push(*collision));
            for _ in 0..5 {
                let settings = &mut engine.strips.settings;
                (settings.entered, settings.depth) = (10.0, 4.0);
                engine
                    .advance(f64::INFINITY, 30_000, &mut observer)
                    .expect("time");
            }
            let settings = engine.settings();
            windows += settings.windows;
            retries += settings.retries;
            fewer |= (2..strips).contains(&(settings.cuts.len().saturating_sub(1)));
            let engine = engine.engine();
            assert!(engine.tally.elastic_contacts > 1000);
            let bytes = postcard::to_stdvec(&engine.checkpoint()).expect("bytes");
            (bytes, seen)
        };
        let alone = run(1);
        for strips in [2, 3, 12] {
            let shared = run(strips);
            assert!(shared.0 == alone.0, "{strips} strips");
            assert!(shared.1 == alone.1, "collisions of {strips} strips");
        }
    }
    assert!(
        retries > 20 && windows > 8 * retries && fewer,
        "{windows} {retries} {fewer}"
    );
}

/// Strips stay from one advance to the next until the gas advances alone, and no result depends on
/// that.
#[test]
fn strips_stay_between_advances() {
    let stages = |strips: usize, depths: [f64; 2]| {
        let mut engine = lattice::<Buckets>(100);
        engine
            .advance(f64::INFINITY, 20_000, &mut ())
            .expect("disorder");
        let mut engine = StripedEngine::new(engine, strips);
        let (from, mut bytes, mut stay) = (engine.engine().time(), Vec::new(), Vec::new());
        for (stage, most) in [u64::MAX, u64::MAX, 40, u64::MAX, u64::MAX]
            .into_iter()
            .enumerate()
        {
            let until = from + 0.3 * (stage + 1) as f64;
            engine.strips.settings.depth = depths[stage % 2];
            let there = engine.advance(until, most, &mut ()).expect("time");
            assert_eq!(there, most == u64::MAX);
            bytes.push(postcard::to_stdvec(&engine.engine().checkpoint()).expect("bytes"));
            stay.push(engine.strips.strips.len());
        }
        (bytes, stay, engine.settings().clone())
    };
    let alone = stages(1, [FIRST_DEPTH; 2]);
    // Windows pay in three strips and not in twelve where wrong events go 60 rows deep. Where they
    // go 20 rows deep they pay in twelve too, but three strips exist already.
    let expected = [(2, [FIRST_DEPTH; 2], 2), (12, [60.0, 20.0], 3)];
    for (strips, depths, few) in expected {
        let (bytes, stay, spread) = stages(strips, depths);
        assert!(spread.windows > 4 && spread.retries == 0, "{spread:?}");
        assert!(bytes == alone.0, "{strips} strips");
        assert_eq!(stay[..3], [few, few, 0], "{strips} strips");
        assert!(stay[4] > 1, "{strips} strips");
    }
}

/// Stale events stay rare when calendars change their buckets in a cooling gas and file all events
/// anew. A strip forgets the events of disks that left it, and has none twice. Here each boundary
/// moves by a row with each window. There are 0.0055 stale events for each event; 0.016 if a strip
/// forgets none, 0.18 if it has some twice.
#[test]
fn strips_forget_the_events_of_disks_that_left() {
    let mut engine = cooling(200);
    // First contacts of a lattice, which say little about later ones.
    engine
        .advance(f64::INFINITY, 80_000, &mut ())
        .expect("time");
    let StripedEngine { mut engine, strips } = StripedEngine::new(engine, 4);
    let settings = strips;
    let mut cuts = settings.cuts(&engine).expect("enough rows");
    let (mut strips, mut parcels) = (Vec::new(), Vec::new());
    let mut now = engine.now;
    let mut window = EACH / Strips::rate_to_come(&engine);
    let (mut stale, mut events) = (0, 0);
    for number in 0..40 {
        for cut in &mut cuts[1..4] {
            *cut += if number % 2 == 0 { 1 } else { -1 };
        }
        let places = settings.places(&engine, &cuts);
        Strips::give_places(&mut engine, &mut strips, &places, &mut parcels, now);
        now += window;
        let goal = Goal {
            end: now,
            ends: false,
            last: u64::MAX,
        };
        let (ended, _) = Strips::run_all(&mut strips, &goal, [u64::MAX; 2], false);
        assert!(ended);
        assert!(matches!(
            Strips::examine(&strips, u64::MAX),
            Outcome::Kept(_)
        ));
        let mut contacts = 0;
        for strip in &strips {
            let its = strip.window.as_ref().expect("a window");
            stale += strip.stale;
            events += its.events - its.twice;
            contacts += its.contacts.len();
        }
        window *= EACH / contacts as f64;
    }
    let stale = stale as f64 / events as f64;
    assert!(stale < 0.01, "{stale} stale for each event");
}

/// Boundaries move half of the way to where work would be equal, and not so far that a strip is too
/// low for its halos.
#[test]
fn boundaries_follow_the_work() {
    let cuts = cut::equal_cuts(300, 3).expect("cuts");
    assert_eq!(cuts, [0, 100, 200, 300]);
    assert_eq!(cut::better_cuts(&cuts, &[1.0, 1.0, 1.0]), cuts);
    // Two thirds of the work are in the first strip, so that the best boundaries are at 50 and 100.
    assert_eq!(cut::better_cuts(&cuts, &[4.0, 1.0, 1.0]), [0, 75, 150, 300]);
    assert_eq!(
        [2, 3, 5, 12].map(cut::fewer),
        [None, Some(2), Some(2), Some(6)]
    );
    assert_eq!(cut::fewer_cuts(&[0, 4, 8, 12, 16, 20], 2), [0, 8, 20]);
    assert_eq!(cut::fewer_cuts(&[0, 4, 8, 12], 2), [0, 4, 12]);
    let low = cut::equal_cuts(36, 3).expect("cuts");
    assert_eq!(cut::better_cuts(&low, &[4.0, 1.0, 1.0]), low);
    assert_eq!(cut::equal_cuts(35, 3), None);
}
