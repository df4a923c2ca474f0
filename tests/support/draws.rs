//! Random cases that are the same in every run.

use proptest::strategy::Strategy;
use proptest::test_runner::{Config, RngAlgorithm, RngSeed, TestCaseError, TestRng, TestRunner};

/// Tests a property on values that proptest draws from a fixed seed. It keeps no files, and shrinks
/// a value that fails.
pub fn drawn<S: Strategy>(
    times: u32,
    seed: u64,
    values: &S,
    look: impl Fn(S::Value) -> Result<(), TestCaseError>,
) {
    let config = Config {
        cases: times,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(seed),
        ..Config::default()
    };
    let stream = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    TestRunner::new_with_rng(config, stream)
        .run(values, look)
        .unwrap_or_else(|failure| panic!("{failure}"));
}
