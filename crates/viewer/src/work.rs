//! Work that takes too long for the thread that serves all.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use axum::http::StatusCode;
use thread_priority::{ThreadPriority, set_current_thread_priority};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};
use tokio::time::timeout;
use tracing::debug;

use crate::api_error::ApiError;

/// Threads for what takes milliseconds.
pub(crate) const THREADS: usize = 4;

/// Does what takes milliseconds, where it does not hold up others.
pub(crate) async fn work<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, ApiError> + Send + 'static,
) -> Result<T, ApiError> {
    tokio::task::spawn_blocking(work).await.map_err(ApiError::failed)?
}

/// A queue for work of one kind that takes seconds, with a limited number of turns at a time.
pub(crate) struct Queue {
    /// What is worked on, in the plural.
    kind: &'static str,
    turns: Arc<Semaphore>,
    max_wait: Duration,
    in_background: bool,
}

impl Queue {
    pub(crate) fn new(kind: &'static str, turns: usize, max_wait: Duration) -> Self {
        let turns = Arc::new(Semaphore::new(turns));
        Self { kind, turns, max_wait, in_background: false }
    }

    /// Runs the work at the lowest priority, so that it does not slow a search. On a busy machine it
    /// takes long then.
    pub(crate) fn in_background(self) -> Self {
        Self { in_background: true, ..self }
    }

    /// Waits for a turn, which ends when it is dropped.
    pub(crate) async fn turn(&self) -> Result<OwnedSemaphorePermit, ApiError> {
        let turn = timeout(self.max_wait, Arc::clone(&self.turns).acquire_owned()).await;
        let busy = |_| {
            let text = format!("the server is busy with other {} (try again later)", self.kind);
            ApiError::new(StatusCode::SERVICE_UNAVAILABLE, text)
        };
        turn.map_err(busy)?.map_err(ApiError::failed)
    }

    /// Waits for a turn and runs the work on a thread of its own: one that has lowered its priority
    /// may not raise it again. The work has to check now and then whether its client still waits.
    pub(crate) async fn work<T: Send + 'static>(
        &self,
        work: impl FnOnce(&CancelToken) -> Result<T, ApiError> + Send + 'static,
    ) -> Result<T, ApiError> {
        let turn = self.turn().await?;
        let asked = Asked(Arc::default());
        let wanted = CancelToken(Arc::clone(&asked.0));
        let (answer, answered) = oneshot::channel();
        let in_background = self.in_background;
        let run = move || {
            // Ends with the work, not when whoever asked has gone.
            let _turn = turn;
            if in_background && let Err(error) = lower_priority() {
                debug!("the priority of work stays as it is: {error}");
            }
            // Nobody may wait for it any more.
            let _ = answer.send(work(&wanted));
        };
        thread::Builder::new().name(self.kind.into()).spawn(run).map_err(ApiError::failed)?;
        answered.await.map_err(ApiError::failed)?
    }
}

/// Gives this thread the lowest priority, where a thread has one of its own.
fn lower_priority() -> Result<(), thread_priority::Error> {
    if cfg!(any(target_os = "linux", target_os = "macos", windows)) {
        return set_current_thread_priority(ThreadPriority::Min);
    }
    Ok(())
}

/// Dropped by who asked when they have their answer, or go.
struct Asked(Arc<AtomicBool>);

impl Drop for Asked {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Whether somebody still waits for the work.
pub(crate) struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    /// Refuses to go on if nobody waits.
    pub(crate) fn check(&self) -> Result<(), ApiError> {
        if self.0.load(Ordering::Relaxed) {
            return Err(ApiError::new(StatusCode::REQUEST_TIMEOUT, "nobody waits for it any more"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicUsize;
    use std::sync::mpsc;
    use std::time::Instant;

    use futures_util::future::join3;
    use mmsim_tests::PATIENCE;
    use tokio::runtime;

    use super::*;

    fn run<T>(test: impl Future<Output = T>) -> T {
        runtime::Builder::new_current_thread().enable_time().build().unwrap().block_on(test)
    }

    /// Works until nobody waits for it; returns whether that was so.
    fn work_on(wanted: &CancelToken) -> bool {
        let begun = Instant::now();
        while wanted.check().is_ok() && begun.elapsed() < PATIENCE {
            thread::sleep(Duration::from_millis(1));
        }
        wanted.check().is_err()
    }

    #[test]
    fn work_that_nobody_waits_for_ends_and_leaves_room() {
        run(async {
            let queue = Queue::new("tests", 2, PATIENCE);
            let (tell, told) = mpsc::channel();
            for _ in 0..6 {
                let tell = tell.clone();
                let endless = queue.work(move |wanted| {
                    let _ = tell.send(work_on(wanted));
                    wanted.check()
                });
                // Whoever asked goes, from the queue or while the work is done.
                assert!(timeout(Duration::from_millis(20), endless).await.is_err());
            }
            assert_eq!(queue.work(|wanted| wanted.check().map(|()| 7)).await.ok(), Some(7));
            drop(tell);
            assert!(told.iter().all(|given_up| given_up));
        });
    }

    #[test]
    fn a_client_that_leaves_the_queue_gets_no_turn() {
        run(async {
            let queue = Queue::new("tests", 1, PATIENCE);
            let turn = queue.turn().await.unwrap();
            let left = queue.work(|_| -> Result<(), ApiError> { panic!("nobody waits for it") });
            assert!(timeout(Duration::from_millis(20), left).await.is_err());
            drop(turn);
            assert_eq!(queue.work(|_| Ok(7)).await.unwrap(), 7);
        });
    }

    #[test]
    fn turns_are_limited_and_so_is_the_wait_for_one() {
        static NOW: AtomicUsize = AtomicUsize::new(0);
        let busy = |_: &CancelToken| {
            assert_eq!(NOW.fetch_add(1, Ordering::SeqCst), 0, "one at a time");
            thread::sleep(Duration::from_millis(10));
            NOW.fetch_sub(1, Ordering::SeqCst);
            Ok(())
        };
        run(async {
            let queue = Queue::new("tests", 1, PATIENCE);
            let (a, b, c) = join3(queue.work(busy), queue.work(busy), queue.work(busy)).await;
            a.and(b).and(c).unwrap();
            let queue = Queue::new("tests", 1, Duration::ZERO);
            let turn = queue.turn().await.unwrap();
            let refusal = queue.turn().await.unwrap_err();
            assert_eq!(refusal.status, StatusCode::SERVICE_UNAVAILABLE);
            assert_eq!(refusal.text, "the server is busy with other tests (try again later)");
            drop(turn);
            assert!(queue.turn().await.is_ok());
        });
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn work_in_the_background_has_the_lowest_priority() {
        fn nice() -> i32 {
            let stat = std::fs::read_to_string("/proc/thread-self/stat").unwrap();
            // The 19th field; the 3rd follows the name in brackets.
            stat.rsplit(") ").next().unwrap().split(' ').nth(19 - 3).unwrap().parse().unwrap()
        }
        let usual = nice();
        let queue = Queue::new("tests", 1, PATIENCE);
        assert_eq!(run(queue.work(|_| Ok(nice()))).unwrap(), usual);
        let queue = queue.in_background();
        assert_eq!(run(queue.work(|_| Ok(nice()))).unwrap(), 19);
        assert_eq!(nice(), usual, "that of others stays as it is");
    }
}
