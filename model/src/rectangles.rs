//! Bounding-volume hierarchy of rectangles in the plane: candidates of overlaps and contacts.

use nalgebra::Vector2;

/// Rectangle along the axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rectangle {
    /// Lower left corner \[length\].
    pub least: Vector2<f64>,
    /// Upper right corner \[length\].
    pub most: Vector2<f64>,
}

impl Rectangle {
    /// Returns the rectangle that reaches as far from a point along both axes.
    pub fn around(centre: Vector2<f64>, reach: f64) -> Self {
        Self {
            least: centre.add_scalar(-reach),
            most: centre.add_scalar(reach),
        }
    }

    /// Returns this rectangle, wider by a length on all sides.
    pub fn widened(self, by: f64) -> Self {
        Self {
            least: self.least.add_scalar(-by),
            most: self.most.add_scalar(by),
        }
    }

    /// Returns true if the rectangles overlap or touch.
    #[inline]
    pub fn meets(&self, other: &Self) -> bool {
        (self.least[0] <= other.most[0])
            & (self.least[1] <= other.most[1])
            & (other.least[0] <= self.most[0])
            & (other.least[1] <= self.most[1])
    }

    fn joined(self, other: &Self) -> Self {
        Self {
            least: self.least.inf(&other.least),
            most: self.most.sup(&other.most),
        }
    }
}

/// Node of the tree: a rectangle, or the bounds of several.
struct Node {
    bounds: Rectangle,
    /// Index of the first node that is not below this one.
    after: usize,
    /// Index of the rectangle, of a leaf.
    leaf: Option<u32>,
}

/// Binary tree of rectangles, halved along the longer side of their bounds.
///
/// Nodes are stored in the order in which a search goes through them, so it needs no stack. Cost
/// N log N, and log N for each rectangle found.
pub(crate) struct RectangleTree {
    nodes: Vec<Node>,
}

impl RectangleTree {
    /// Builds the tree.
    pub fn new(rectangles: &[Rectangle]) -> Self {
        let mut tree = Self {
            nodes: Vec::with_capacity(2 * rectangles.len()),
        };
        let mut order: Vec<u32> = (0..rectangles.len() as u32).collect();
        if !order.is_empty() {
            tree.add(rectangles, &mut order);
        }
        tree
    }

    fn add(&mut self, rectangles: &[Rectangle], some: &mut [u32]) {
        let of = |index: &u32| &rectangles[*index as usize];
        let bounds = some[1..]
            .iter()
            .map(of)
            .fold(*of(&some[0]), Rectangle::joined);
        let place = self.nodes.len();
        let leaf = (some.len() == 1).then_some(some[0]);
        self.nodes.push(Node {
            bounds,
            after: place + 1,
            leaf,
        });
        if leaf.is_some() {
            return;
        }
        let axis = usize::from((bounds.most - bounds.least).imax() == 1);
        let twice_centre = |index: &u32| of(index).least[axis] + of(index).most[axis];
        let (middle, half) = (some.len() / 2, |a: &u32, b: &u32| {
            twice_centre(a).total_cmp(&twice_centre(b)).then(a.cmp(b))
        });
        some.select_nth_unstable_by(middle, half);
        let (low, high) = some.split_at_mut(middle);
        self.add(rectangles, low);
        self.add(rectangles, high);
        self.nodes[place].after = self.nodes.len();
    }

    /// Bounds of all rectangles; `None` without any.
    pub fn bounds(&self) -> Option<&Rectangle> {
        self.nodes.first().map(|root| &root.bounds)
    }

    /// Returns the indices of the rectangles that meet one.
    #[inline]
    pub fn meeting<'a>(&'a self, rectangle: &'a Rectangle) -> impl Iterator<Item = u32> + 'a {
        let mut next = 0;
        std::iter::from_fn(move || {
            while let Some(node) = self.nodes.get(next) {
                if !node.bounds.meets(rectangle) {
                    next = node.after;
                    continue;
                }
                next += 1;
                if node.leaf.is_some() {
                    return node.leaf;
                }
            }
            None
        })
    }

    /// Returns true if any two rectangles that meet, by index, are what is sought.
    pub fn has_pair(&self, sought: &impl Fn(u32, u32) -> bool) -> bool {
        !self.nodes.is_empty() && self.has_pair_within(0, sought)
    }

    fn has_pair_within(&self, node: usize, sought: &impl Fn(u32, u32) -> bool) -> bool {
        if self.nodes[node].leaf.is_some() {
            return false;
        }
        let halves = self.halves(node);
        self.has_pair_within(halves[0], sought)
            || self.has_pair_within(halves[1], sought)
            || self.has_pair_between(halves, sought)
    }

    fn has_pair_between(&self, pair: [usize; 2], sought: &impl Fn(u32, u32) -> bool) -> bool {
        let [one, other] = pair.map(|node| &self.nodes[node]);
        if !one.bounds.meets(&other.bounds) {
            return false;
        }
        if let (Some(first), Some(second)) = (one.leaf, other.leaf) {
            return sought(first, second);
        }
        // The node with more below it is divided.
        let size = |number: usize| self.nodes[pair[number]].after - pair[number];
        let (large, small) = if size(0) < size(1) { (1, 0) } else { (0, 1) };
        (self.halves(pair[large]).into_iter())
            .any(|half| self.has_pair_between([half, pair[small]], sought))
    }

    fn halves(&self, node: usize) -> [usize; 2] {
        [node + 1, self.nodes[node + 1].after]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::vector;
    use rand::{RngExt, SeedableRng};

    /// Searches against all rectangles one by one, for none to hundreds, among them equal ones.
    #[test]
    fn finds_what_all_pairs_find() {
        let mut stream = crate::random::Stream::seed_from_u64(7);
        let (mut found, mut pairs) = (0, [0; 2]);
        for round in 0..400_usize {
            let all: Vec<Rectangle> = (0..round)
                .map(|_| {
                    let mut number = || f64::from(stream.random_range(0..200_u32));
                    let centre = vector![number(), number()];
                    Rectangle::around(centre, number() * 0.01).widened(0.5)
                })
                .collect();
            let tree = RectangleTree::new(&all);
            let around = Rectangle::around(vector![70.0, 110.0], 30.0);
            let mut ours: Vec<u32> = tree.meeting(&around).collect();
            ours.sort_unstable();
            let plain: Vec<u32> = (0..)
                .zip(&all)
                .filter_map(|(index, one)| one.meets(&around).then_some(index))
                .collect();
            assert_eq!(ours, plain);
            found += plain.len();
            assert_eq!(tree.bounds().is_some(), round > 0);

            // Each pair once.
            let seen = std::cell::RefCell::new(Vec::new());
            let note = |first: u32, second: u32| {
                seen.borrow_mut()
                    .push([first.min(second), first.max(second)]);
                false
            };
            assert!(!tree.has_pair(&note));
            let mut ours = seen.into_inner();
            ours.sort_unstable();
            let plain: Vec<[u32; 2]> = (0..round as u32)
                .flat_map(|first| (first + 1..round as u32).map(move |second| [first, second]))
                .filter(|pair| all[pair[0] as usize].meets(&all[pair[1] as usize]))
                .collect();
            assert_eq!(ours, plain);
            pairs[usize::from(plain.is_empty())] += 1;
            if let Some(&[first, second]) = plain.last() {
                let last = |a: u32, b: u32| [a.min(b), a.max(b)] == [first, second];
                assert!(tree.has_pair(&last));
            }
        }
        assert!(
            found > 1000 && pairs[0] > 100 && pairs[1] > 5,
            "{found} {pairs:?}"
        );
    }
}
