//! What is expensive to build and the same for many instances: built once, shared while somebody uses it.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

/// Where the thing of one key is, or is being built.
type Place<T> = Arc<Mutex<Weak<T>>>;

/// Things that are alive, by their keys. Different ones are built at the same time, equal ones once.
#[derive(Debug)]
pub(crate) struct Registry<K, T> {
    places: Mutex<Vec<(K, Place<T>)>>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<K: PartialEq, T> Registry<K, T> {
    /// Without anything.
    pub const fn new() -> Self {
        Self { places: Mutex::new(Vec::new()) }
    }

    /// The living thing of `key`, or what `build` makes. Others wait only for the same key.
    ///
    /// # Errors
    /// What `build` says.
    pub fn share<E>(&self, key: K, build: impl FnOnce() -> Result<T, E>) -> Result<Arc<T>, E> {
        let place = self.place(key);
        let mut held = lock(&place);
        if let Some(thing) = held.upgrade() {
            return Ok(thing);
        }
        let thing = Arc::new(build()?);
        *held = Arc::downgrade(&thing);
        Ok(thing)
    }

    fn place(&self, key: K) -> Place<T> {
        let mut places = lock(&self.places);
        if let Some((_, place)) = places.iter().find(|(k, _)| *k == key) {
            return Arc::clone(place);
        }
        let place = Place::default();
        places.push((key, Arc::clone(&place)));
        place
    }

    /// Forgets what nobody uses or builds; called when a thing dies, so that a host that unloads the library
    /// does not keep memory.
    pub fn forget_dead(&self) {
        let mut places = lock(&self.places);
        places.retain(|(_, place)| {
            Arc::strong_count(place) > 1 || place.try_lock().map_or(true, |held| held.strong_count() > 0)
        });
        places.shrink_to_fit();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::mpsc::channel;
    use std::time::Duration;

    /// Each of two builders waits until the other has begun: one after the other, neither would end.
    #[test]
    fn different_things_are_built_at_the_same_time() {
        static REGISTRY: Registry<u8, u8> = Registry::new();
        let (first, second) = (channel(), channel());
        let builder = |key, begun: std::sync::mpsc::Sender<()>, other: std::sync::mpsc::Receiver<()>| {
            std::thread::spawn(move || {
                let build = || {
                    begun.send(()).map_err(|_| "the other builder is gone")?;
                    other.recv_timeout(Duration::from_secs(20)).map_err(|_| "the other builder waits")?;
                    Ok::<u8, &str>(key)
                };
                REGISTRY.share(key, build).map(|thing| *thing)
            })
        };
        let threads = [builder(1, first.0, second.1), builder(2, second.0, first.1)];
        assert_eq!(threads.map(|thread| thread.join().unwrap()), [Ok(1), Ok(2)]);
    }

    #[test]
    fn equal_things_are_built_once_and_forgotten_when_dead() {
        static REGISTRY: Registry<u8, usize> = Registry::new();
        static BUILT: AtomicUsize = AtomicUsize::new(0);
        let share = || {
            let build = || {
                std::thread::sleep(Duration::from_millis(20));
                Ok::<_, Infallible>(BUILT.fetch_add(1, Ordering::SeqCst))
            };
            let Ok(thing) = REGISTRY.share(7, build);
            thing
        };
        let things: Vec<_> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..4).map(|_| scope.spawn(share)).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        assert!(things.iter().all(|thing| Arc::ptr_eq(thing, &things[0])));
        assert_eq!(BUILT.load(Ordering::SeqCst), 1);
        REGISTRY.forget_dead();
        assert_eq!(lock(&REGISTRY.places).len(), 1, "it is alive");
        drop(things);
        REGISTRY.forget_dead();
        assert_eq!(lock(&REGISTRY.places).len(), 0);
        assert!(REGISTRY.share(7, || Err::<usize, _>("fails")).is_err());
        REGISTRY.forget_dead();
        assert_eq!(lock(&REGISTRY.places).len(), 0, "a failure leaves nothing");
        assert_eq!(*share(), 1);
    }
}
