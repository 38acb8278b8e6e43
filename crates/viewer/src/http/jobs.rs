//! Jobs that would block the web server thread for too long, and the errors that end requests.

use std::collections::HashMap;
use std::io::{self, Read, Seek, SeekFrom};
use std::net::IpAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::thread;
use std::time::Duration;

use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use mmsim_server::MonitorError;
use tokio::sync::{AcquireError, OwnedSemaphorePermit, Semaphore, oneshot};
use tokio::time::timeout;
use tracing::debug;

/// The result of answering a request.
pub(crate) type ApiResult<T> = Result<T, ApiError>;

/// An error response: a status and a message that the page shows.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{text}")]
pub(crate) struct ApiError {
    pub(crate) status: StatusCode,
    pub(crate) text: String,
}

#[expect(clippy::needless_pass_by_value, reason = "`map_err` passes errors by value")]
impl ApiError {
    pub(crate) fn new(status: StatusCode, text: impl ToString) -> Self {
        Self { status, text: text.to_string() }
    }

    pub(crate) fn not_found(text: impl ToString) -> Self {
        Self::new(StatusCode::NOT_FOUND, text)
    }

    pub(crate) fn bad_request(text: impl ToString) -> Self {
        Self::new(StatusCode::BAD_REQUEST, text)
    }

    pub(crate) fn conflict(text: impl ToString) -> Self {
        Self::new(StatusCode::CONFLICT, text)
    }

    pub(crate) fn internal(text: impl ToString) -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, text)
    }
}

impl From<MonitorError> for ApiError {
    fn from(error: MonitorError) -> Self {
        let status = match error {
            MonitorError::RunEnded { .. } => StatusCode::GONE,
            MonitorError::HasClient => StatusCode::CONFLICT,
            MonitorError::Ended => StatusCode::SERVICE_UNAVAILABLE,
        };
        Self::new(status, error)
    }
}

impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        (self.status, self.text).into_response()
    }
}

/// The maximum number of threads for [`run_blocking`].
pub(crate) const MAX_BLOCKING_THREADS: usize = 4;

/// Runs a short job on a thread pool for blocking jobs. The job should take only a few
/// milliseconds.
pub(crate) async fn run_blocking<T: Send + 'static>(
    job: impl FnOnce() -> ApiResult<T> + Send + 'static,
) -> ApiResult<T> {
    tokio::task::spawn_blocking(job).await.map_err(ApiError::internal)?
}

/// The right to run a job, with the share of its network.
pub(crate) struct Permit(
    #[expect(dead_code, reason = "held until dropped")] OwnedSemaphorePermit,
    #[expect(dead_code, reason = "held until dropped")] Option<OwnedSemaphorePermit>,
);

/// A queue for slow jobs of one kind. The queue limits the number of jobs that run at the same
/// time.
pub(crate) struct JobQueue {
    /// The plural name of the jobs, such as `pictures`.
    kind: &'static str,
    permits: Arc<Semaphore>,
    /// The shares of networks whose clients hold a permit or wait for one.
    shares: Mutex<HashMap<IpAddr, Weak<Semaphore>>>,
    max_wait: Duration,
    in_background: bool,
}

impl JobQueue {
    pub(crate) fn new(kind: &'static str, max_jobs: usize, max_wait: Duration) -> Self {
        let permits = Arc::new(Semaphore::new(max_jobs));
        Self { kind, permits, shares: Mutex::default(), max_wait, in_background: false }
    }

    /// Runs the jobs at the lowest priority, so that they do not slow down a search. On a busy
    /// machine, jobs at this priority may take a long time.
    pub(crate) fn in_background(self) -> Self {
        Self { in_background: true, ..self }
    }

    /// Waits for a permit to run a job. If the network of a client is given, waits until this network
    /// holds no other permit, so that networks take turns.
    pub(crate) async fn acquire(&self, network: Option<IpAddr>) -> ApiResult<Permit> {
        let share = network.map(|network| self.share(network));
        let acquire = async {
            let share = match share {
                Some(share) => Some(share.acquire_owned().await?),
                None => None,
            };
            Ok(Permit(Arc::clone(&self.permits).acquire_owned().await?, share))
        };
        let permit = timeout(self.max_wait, acquire).await;
        let busy = |_| {
            let text = format!("the server is busy with other {} (try again later)", self.kind);
            ApiError::new(StatusCode::SERVICE_UNAVAILABLE, text)
        };
        permit.map_err(busy)?.map_err(|error: AcquireError| ApiError::internal(error))
    }

    /// Returns the permit of one network.
    fn share(&self, network: IpAddr) -> Arc<Semaphore> {
        let mut shares = self.shares.lock().unwrap_or_else(PoisonError::into_inner);
        shares.retain(|_, share| share.strong_count() > 0);
        let share = shares.get(&network).and_then(Weak::upgrade);
        share.unwrap_or_else(|| {
            let new = Arc::new(Semaphore::new(1));
            shares.insert(network, Arc::downgrade(&new));
            new
        })
    }

    /// Waits for a permit and runs the job on a new thread. The thread is not reused, since a
    /// thread that has lowered its priority cannot raise it again. A long job must check the cancel
    /// token regularly.
    pub(crate) async fn run<T: Send + 'static>(
        &self,
        job: impl FnOnce(&CancelToken) -> ApiResult<T> + Send + 'static,
    ) -> ApiResult<T> {
        self.run_for(None, job).await
    }

    /// Like [`run`](Self::run), but runs one job of a network at a time.
    pub(crate) async fn run_for<T: Send + 'static>(
        &self,
        network: Option<IpAddr>,
        job: impl FnOnce(&CancelToken) -> ApiResult<T> + Send + 'static,
    ) -> ApiResult<T> {
        let permit = self.acquire(network).await?;
        let guard = CancelOnDrop(Arc::default());
        let cancel = CancelToken(Arc::clone(&guard.0));
        let (sender, receiver) = oneshot::channel();
        let in_background = self.in_background;
        let run = move || {
            // Released at the end of the job, even if the client disconnects earlier.
            let _permit = permit;
            if in_background {
                lower_priority();
            }
            // Fails if the client has disconnected.
            let _ = sender.send(job(&cancel));
        };
        thread::Builder::new().name(self.kind.into()).spawn(run).map_err(ApiError::internal)?;
        receiver.await.map_err(ApiError::internal)?
    }
}

/// Gives the current thread the lowest priority, on systems where threads have priorities.
fn lower_priority() {
    // On Linux, the nice value of "this process" is that of the calling thread.
    #[cfg(target_os = "linux")]
    let lowered = rustix::process::setpriority_process(None, 19);
    #[cfg(any(target_os = "macos", windows))]
    let lowered =
        thread_priority::set_current_thread_priority(thread_priority::ThreadPriority::Min);
    #[cfg(any(target_os = "linux", target_os = "macos", windows))]
    if let Err(error) = lowered {
        debug!("cannot lower the priority of a job: {error}");
    }
}

/// A guard that cancels the job when the request is dropped.
struct CancelOnDrop(Arc<AtomicBool>);

impl Drop for CancelOnDrop {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// A token that tells a job whether its client has disconnected. The default token is never
/// cancelled.
#[derive(Default)]
pub(crate) struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    /// Returns an error if the client has disconnected.
    pub(crate) fn check(&self) -> ApiResult<()> {
        if self.0.load(Ordering::Relaxed) {
            return Err(ApiError::new(StatusCode::REQUEST_TIMEOUT, "request cancelled"));
        }
        Ok(())
    }

    /// Returns a reader of `source` that fails once the client has disconnected.
    pub(crate) const fn reader<R>(&self, source: R) -> CancellableReader<'_, R> {
        CancellableReader { source, cancel: self }
    }
}

/// A reader that fails once its client has disconnected.
pub(crate) struct CancellableReader<'c, R> {
    source: R,
    cancel: &'c CancelToken,
}

impl<R: Read> Read for CancellableReader<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.cancel.check().map_err(io::Error::other)?;
        self.source.read(buffer)
    }
}

impl<R: Seek> Seek for CancellableReader<'_, R> {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        self.source.seek(position)
    }
}

#[cfg(test)]
mod tests {
    use std::pin::pin;
    use std::sync::mpsc;
    use std::time::Instant;

    use futures_util::FutureExt;
    use futures_util::future::join;
    use tokio::runtime;

    use super::*;

    impl CancelToken {
        /// Creates a token that is cancelled already.
        pub(crate) fn cancelled() -> Self {
            Self(Arc::new(AtomicBool::new(true)))
        }
    }

    /// The time limit of a wait, long enough for a busy machine.
    const TIMEOUT: Duration = Duration::from_secs(300);

    fn run<T>(test: impl Future<Output = T>) -> T {
        runtime::Builder::new_current_thread().enable_time().build().unwrap().block_on(test)
    }

    /// Waits until the job is cancelled or a timeout expires. Returns true if the job was
    /// cancelled.
    fn run_until_cancelled(cancel: &CancelToken) -> bool {
        let started = Instant::now();
        while cancel.check().is_ok() && started.elapsed() < TIMEOUT {
            thread::sleep(Duration::from_millis(1));
        }
        cancel.check().is_err()
    }

    #[test]
    fn a_cancelled_job_ends_and_frees_its_permit() {
        run(async {
            let queue = JobQueue::new("tests", 2, TIMEOUT);
            let (sender, outcomes) = mpsc::channel();
            for _ in 0..6 {
                let sender = sender.clone();
                let endless = queue.run(move |cancel| {
                    let _ = sender.send(run_until_cancelled(cancel));
                    cancel.check()
                });
                // The client disconnects while the job waits in the queue or runs.
                assert!(endless.now_or_never().is_none());
            }
            assert_eq!(queue.run(|cancel| cancel.check().map(|()| 7)).await.ok(), Some(7));
            drop(sender);
            assert!(outcomes.iter().all(|was_cancelled| was_cancelled));
        });
    }

    #[test]
    fn a_client_that_leaves_the_queue_runs_no_job() {
        run(async {
            let queue = JobQueue::new("tests", 1, TIMEOUT);
            let permit = queue.acquire(None).await.unwrap();
            let cancelled = queue.run(|_| -> Result<(), ApiError> { panic!("must not run") });
            assert!(cancelled.now_or_never().is_none());
            drop(permit);
            assert_eq!(queue.run(|_| Ok(7)).await.unwrap(), 7);
        });
    }

    #[test]
    fn concurrent_jobs_and_waiting_times_are_limited() {
        run(async {
            let queue = JobQueue::new("tests", 1, TIMEOUT);
            let (release, released) = mpsc::channel();
            let (started, has_started) = mpsc::channel();
            let also_started = started.clone();
            let mut first = pin!(queue.run(move |_| {
                started.send(1).unwrap();
                released.recv_timeout(TIMEOUT).unwrap();
                Ok(())
            }));
            let mut second = pin!(queue.run(move |_| {
                also_started.send(2).unwrap();
                Ok(())
            }));
            // A job starts when it is polled, unless it has to wait.
            assert!(first.as_mut().now_or_never().is_none());
            assert!(second.as_mut().now_or_never().is_none());
            assert_eq!(has_started.recv_timeout(TIMEOUT), Ok(1));
            assert!(has_started.try_recv().is_err(), "one at a time");
            release.send(()).unwrap();
            let (first, second) = join(first, second).await;
            first.and(second).unwrap();
            assert_eq!(has_started.recv(), Ok(2));
            let queue = JobQueue::new("tests", 1, Duration::ZERO);
            let permit = queue.acquire(None).await.unwrap();
            let error = queue.acquire(None).await.err().unwrap();
            assert_eq!(error.status, StatusCode::SERVICE_UNAVAILABLE);
            assert_eq!(error.text, "the server is busy with other tests (try again later)");
            drop(permit);
            assert!(queue.acquire(None).await.is_ok());
        });
    }

    #[test]
    fn clients_take_turns() {
        run(async {
            let queue = JobQueue::new("tests", 2, TIMEOUT);
            let [greedy, other] = [[1, 1, 1, 1], [2, 2, 2, 2]].map(IpAddr::from);
            let held = queue.acquire(Some(greedy)).await.unwrap();
            let mut more: Vec<_> = (0..6).map(|_| Box::pin(queue.acquire(Some(greedy)))).collect();
            for waiting in &mut more {
                assert!(waiting.as_mut().now_or_never().is_none(), "one place for each client");
            }
            assert!(queue.acquire(Some(other)).now_or_never().is_some_and(|taken| taken.is_ok()));
            drop(held);
            let next = more.remove(0).await.unwrap();
            assert!(queue.acquire(Some(other)).now_or_never().is_some());
            drop((next, more));
            assert!(queue.acquire(Some(greedy)).now_or_never().is_some());
            drop(queue.acquire(Some(other)).await);
            assert!(queue.shares.lock().unwrap().len() <= 2);
        });
    }

    #[test]
    fn a_cancelled_reader_fails() {
        let mut text = String::new();
        assert!(CancelToken::default().reader(&b"a"[..]).read_to_string(&mut text).is_ok());
        assert!(CancelToken::cancelled().reader(&b"a"[..]).read_to_string(&mut text).is_err());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn background_jobs_have_the_lowest_priority() {
        fn nice() -> i32 {
            let stat = std::fs::read_to_string("/proc/thread-self/stat").unwrap();
            // The nice value is the 19th field. The text after the name in parentheses starts with
            // the 3rd field.
            stat.rsplit(") ").next().unwrap().split(' ').nth(19 - 3).unwrap().parse().unwrap()
        }
        let normal = nice();
        let queue = JobQueue::new("tests", 1, TIMEOUT);
        assert_eq!(run(queue.run(|_| Ok(nice()))).unwrap(), normal);
        let queue = queue.in_background();
        assert_eq!(run(queue.run(|_| Ok(nice()))).unwrap(), 19);
        assert_eq!(nice(), normal, "the priority of other threads is unchanged");
    }
}
