//! Effects that these data cannot tell apart.

use crate::inference::Signature;

/// Groups of confusable signatures (indices), each joined to at least one other of its group; singles are groups of
/// one.
pub fn groups(signatures: &[&Signature]) -> Vec<Vec<usize>> {
    let n = signatures.len();
    let mut group: Vec<usize> = (0..n).collect();
    for i in 0..n {
        for j in 0..i {
            if signatures[i].looks_like(signatures[j]) {
                let (from, to) = (group[i].max(group[j]), group[i].min(group[j]));
                group.iter_mut().filter(|g| **g == from).for_each(|g| *g = to);
            }
        }
    }
    let members = |g: usize| (0..n).filter(|&i| group[i] == g).collect::<Vec<_>>();
    (0..n).map(members).filter(|m| !m.is_empty()).collect()
}
