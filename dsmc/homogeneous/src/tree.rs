//! Binary tree of partial sums: a weight is changed, or drawn at random, in logarithmic time.

use serde::{Deserialize, Serialize};

/// Binary tree of partial sums of weights. A node is summed again from its two children when one of
/// them changes, so rounding does not accumulate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct SumTree {
    /// Partial sums of the weights in a binary tree: node 1 is the root, the leaves are the upper
    /// half.
    nodes: Vec<f64>,
}

impl SumTree {
    /// Creates a tree of partial sums of `count` weights, all zero.
    pub fn new(count: usize) -> Self {
        Self {
            nodes: vec![0.0; 2 * count.next_power_of_two()],
        }
    }

    /// Returns the sum of all weights.
    #[inline]
    pub fn total(&self) -> f64 {
        self.nodes.get(1).copied().unwrap_or(0.0)
    }

    /// Sets the weight at an index, and updates the partial sums above it.
    pub fn set(&mut self, index: usize, weight: f64) {
        let mut node = self.nodes.len() / 2 + index;
        self.nodes[node] = weight;
        while node > 1 {
            node /= 2;
            self.nodes[node] = self.nodes[2 * node] + self.nodes[2 * node + 1];
        }
    }

    /// Returns the index of the weight in whose interval the fraction `u` of the cumulative sum
    /// lies, 0 <= u < 1. The total must be above zero; zero weights are never found.
    #[inline]
    pub fn find_weight(&self, u: f64) -> usize {
        let leaves = self.nodes.len() / 2;
        let mut place = u * self.total();
        let mut node = 1;
        while node < leaves {
            let left = self.nodes[2 * node];
            // Rounding may carry the place beyond the right child's weight, but never into one that
            // is empty.
            let right = place >= left && self.nodes[2 * node + 1] > 0.0;
            node = 2 * node + usize::from(right);
            if right {
                place -= left;
            }
        }
        node - leaves
    }

    /// Returns the memory that the tree occupies \[bytes\].
    pub fn memory_bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shares are found as by a plain scan of cumulative sums.
    #[test]
    fn shares_are_found_as_by_scanning() {
        let weights = [0.0, 2.0, 0.0, 1.0, 4.0, 0.0, 1.0];
        let mut tree = SumTree::new(weights.len());
        for (index, &weight) in weights.iter().enumerate() {
            tree.set(index, 9.0);
            tree.set(index, weight);
        }
        assert_eq!(tree.total(), 8.0);
        for step in 0..800 {
            let u = f64::from(step) / 800.0;
            let mut sum = 0.0;
            let plain = weights.iter().position(|weight| {
                sum += weight;
                u * 8.0 < sum
            });
            assert_eq!(Some(tree.find_weight(u)), plain, "u = {u}");
        }
        assert_eq!(tree.find_weight(1.0), 6);
    }
}
