//! Tasks that wait for runs, at the same time.

use std::thread::ScopedJoinHandle;

/// What tasks give, each of which waits for its runs: those share the pool, and one task after the other would leave cores idle.
pub fn side_by_side<T: Send, F: FnOnce() -> T + Send>(tasks: impl Iterator<Item = F>) -> Vec<T> {
    std::thread::scope(|scope| {
        let begun: Vec<_> = tasks.map(|task| scope.spawn(task)).collect();
        let end = |thread: ScopedJoinHandle<'_, T>| {
            thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        };
        begun.into_iter().map(end).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Barrier;

    #[test]
    fn tasks_wait_for_one_another_and_answer_in_their_order() {
        let all_here = Barrier::new(3);
        let task = |k: usize| {
            let all_here = &all_here;
            move || {
                all_here.wait();
                k
            }
        };
        assert_eq!(side_by_side((0..3).map(task)), [0, 1, 2]);
    }
}
