//! Work that takes too long for the thread that serves all.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use axum::http::StatusCode;
use tokio::sync::Semaphore;

use crate::refusal::Refusal;

/// Threads for all of it.
pub(crate) const THREADS: usize = 4;

/// How much of what takes seconds is done at the same time: there is always somebody for the rest.
static LONG: Semaphore = Semaphore::const_new(THREADS / 2);

/// Does what may take a while, where it does not hold up others.
pub(crate) async fn work<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Refusal> + Send + 'static,
) -> Result<T, Refusal> {
    tokio::task::spawn_blocking(work).await.map_err(Refusal::failed)?
}

/// Does what takes seconds, once it has its turn. It has to look now and then whether it is still
/// wanted: whoever asked may have gone.
pub(crate) async fn long_work<T: Send + 'static>(
    long: impl FnOnce(&Wanted) -> Result<T, Refusal> + Send + 'static,
) -> Result<T, Refusal> {
    let turn = LONG.acquire().await.map_err(Refusal::failed)?;
    let asked = Asked(Arc::default());
    let wanted = Wanted(Arc::clone(&asked.0));
    work(move || {
        // Given up when the work has ended, not when whoever asked has gone.
        let _turn = turn;
        long(&wanted)
    })
    .await
}

/// Dropped by who asked when they have their answer, or go.
struct Asked(Arc<AtomicBool>);

impl Drop for Asked {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Whether somebody still waits for the work.
pub(crate) struct Wanted(Arc<AtomicBool>);

impl Wanted {
    /// Refuses to go on if nobody waits.
    pub(crate) fn check(&self) -> Result<(), Refusal> {
        if self.0.load(Ordering::Relaxed) {
            return Err(Refusal::new(StatusCode::REQUEST_TIMEOUT, "nobody waits for it any more"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;
    use std::thread;
    use std::time::{Duration, Instant};

    use tokio::runtime;
    use tokio::time::timeout;

    use super::*;

    #[test]
    fn work_that_nobody_waits_for_ends_and_leaves_room() {
        let runtime = runtime::Builder::new_current_thread().enable_time().build().unwrap();
        runtime.block_on(async {
            let (tell, told) = mpsc::channel();
            for _ in 0..3 * THREADS {
                let tell = tell.clone();
                let endless = long_work(move |wanted| {
                    let begun = Instant::now();
                    while wanted.check().is_ok() && begun.elapsed() < Duration::from_secs(20) {
                        thread::sleep(Duration::from_millis(1));
                    }
                    let _ = tell.send(begun.elapsed());
                    wanted.check()
                });
                // Whoever asked goes.
                assert!(timeout(Duration::from_millis(20), endless).await.is_err());
            }
            assert_eq!(long_work(|wanted| wanted.check().map(|()| 7)).await.ok(), Some(7));
            drop(tell);
            assert!(told.iter().all(|time| time < Duration::from_secs(10)));
        });
    }
}
