//! The web server of the page.

pub(crate) mod access;
pub(crate) mod api;
pub(crate) mod assets;
pub(crate) mod events;
pub(crate) mod jobs;
pub(crate) mod limits;
pub(crate) mod requested_run;
pub(crate) mod shares;

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use axum::{Router, middleware};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use mmsim_server::{BindError, listen, network};
use tokio::net::TcpListener;
use tokio::runtime;
use tokio::sync::oneshot;
use tokio::time::sleep;
use tower_http::add_extension::AddExtension;
use tower_http::compression::CompressionLayer;
use tower_http::compression::predicate::{NotForContentType, Predicate as _, SizeAbove};
use tracing::{debug, warn};

use crate::app::{AppState, ViewerConfig};
use crate::http::access::{Access, guard, random_digits};
use crate::http::limits::{Limits, TimedConnection};
use crate::http::shares::Shares;

/// The delay before accepting connections again after an error, such as running out of file
/// descriptors, and while all connections are in use.
const RETRY_DELAY: Duration = Duration::from_millis(100);

/// The minimum size, in bytes, at which a text is compressed if the client accepts gzip. Frequent
/// responses, such as the view of a single state, are smaller and therefore not compressed.
const MIN_COMPRESSED_BYTES: u64 = 4096;

/// A web server that is already listening. [`spawn`](Self::spawn) starts serving requests.
///
/// ```
/// use mmsim_server::{Server, Simulation};
/// use mmsim_viewer::{ViewerConfig, Viewer};
/// let maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let server = Server::bind("127.0.0.1", 0)?;
/// let viewer = Viewer::bind("127.0.0.1", 0)?;
/// let config = ViewerConfig::default().with_live(&server, "small.txt".as_ref());
/// let server = server.spawn(Simulation::new("small", maze));
/// let viewer = viewer.spawn(config)?;
/// println!("open {} in a browser", viewer.address());
/// viewer.stop();
/// server.stop()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Viewer {
    listener: std::net::TcpListener,
    access: Access,
    local: SocketAddr,
    limits: Limits,
}

/// A handle to a web server that runs on a separate thread. The web server runs until it is stopped
/// or the process exits.
pub struct ViewerHandle {
    address: String,
    stop: oneshot::Sender<()>,
    thread: JoinHandle<()>,
}

impl Viewer {
    /// Listens on a local address. Port 0 selects a free port. If the address is not a loopback
    /// address, the server creates a token that browsers must send.
    ///
    /// # Errors
    /// Returns an error if the port is in use or the host is not a local address.
    pub fn bind(host: &str, port: u16) -> Result<Self, BindError> {
        let failed = |source| BindError::Listen { host: host.into(), port, source };
        let listener = listen(host, port)?;
        let local = listener.local_addr().map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let is_loopback = local.ip().to_canonical().is_loopback();
        let token = if is_loopback { None } else { Some(random_digits().map_err(failed)?) };
        let access = Access::new(token, local.port());
        Ok(Self { listener, access, local, limits: Limits::default() })
    }

    /// Replaces the limits.
    pub fn with_limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    /// Returns the URL of the page, such as `http://127.0.0.1:6575`. The URL contains the token, if
    /// there is one.
    pub fn address(&self) -> String {
        format!("http://{}{}", self.local, self.access.query())
    }

    /// Starts serving requests on a new thread.
    ///
    /// # Errors
    /// Returns an error if the system cannot create a thread or an event queue.
    pub fn spawn(self, config: ViewerConfig) -> io::Result<ViewerHandle> {
        let (address, (stop, stopped)) = (self.address(), oneshot::channel());
        let runtime = runtime::Builder::new_current_thread()
            .enable_all()
            .max_blocking_threads(jobs::MAX_BLOCKING_THREADS)
            .build()?;
        let (app, limits) = (app(config, self.access, self.limits), self.limits);
        let listener = {
            let _guard = runtime.enter();
            TcpListener::from_std(self.listener)?
        };
        let run = move || {
            runtime.block_on(async {
                tokio::select! {
                    () = accept(listener, app, limits) => {}
                    // An error means that the handle was dropped: serve until the process exits.
                    Ok(()) = stopped => {}
                }
            });
            // Do not wait for running jobs.
            runtime.shutdown_background();
        };
        let thread = thread::Builder::new().name("viewer".into()).spawn(run)?;
        Ok(ViewerHandle { address, stop, thread })
    }
}

impl ViewerHandle {
    /// Returns the URL of the page, with the token if there is one.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Stops the server and closes all connections.
    pub fn stop(self) {
        // Fails if the server has already stopped.
        let _ = self.stop.send(());
        let _ = self.thread.join();
    }
}

/// Returns the paths that a [`Viewer`] serves. The names of path parameters are in braces.
///
/// ```
/// assert!(mmsim_viewer::routes().any(|path| path == "/api/sources/{id}/states"));
/// ```
pub fn routes() -> impl Iterator<Item = String> {
    assets::paths().chain(api::paths().map(Into::into))
}

fn app(config: ViewerConfig, access: Access, limits: Limits) -> Router {
    let is_compressed = SizeAbove::new(MIN_COMPRESSED_BYTES)
        .and(NotForContentType::IMAGES)
        .and(NotForContentType::SSE)
        .and(NotForContentType::const_new(api::BINARY));
    api::router(Arc::new(AppState::new(config, limits)))
        .layer(CompressionLayer::new().compress_when(is_compressed))
        .layer(middleware::from_fn_with_state(Arc::new(access), guard))
}

/// Accepts connections up to the limit and serves each connection in a separate task.
async fn accept(listener: TcpListener, app: Router, limits: Limits) {
    let shares = Arc::new(Shares::new(limits.connections, limits.streams));
    let mut warned = false;
    loop {
        let (stream, network) = match listener.accept().await {
            Ok((stream, address)) => (stream, network(address.ip())),
            Err(error) => {
                // Warn only once, since every attempt fails while there are no file descriptors.
                if !std::mem::replace(&mut warned, true) {
                    warn!("cannot accept a connection to the page: {error}");
                }
                sleep(RETRY_DELAY).await;
                continue;
            }
        };
        let connection = loop {
            match shares.add(network, Instant::now()) {
                Some(connection) => break connection,
                None => sleep(RETRY_DELAY).await,
            }
        };
        // Send small responses without delay.
        let _ = stream.set_nodelay(true);
        let client = AddExtension::new(app.clone(), Arc::clone(&connection));
        let service = TowerToHyperService::new(AddExtension::new(client, Arc::clone(&shares)));
        let (stream, shares) =
            (TimedConnection::new(stream, Arc::clone(&connection), limits), Arc::clone(&shares));
        tokio::spawn(async move {
            let served = http1::Builder::new()
                .timer(TokioTimer::new())
                .header_read_timeout(limits.header_time)
                .serve_connection(TokioIo::new(stream), service);
            tokio::select! {
                ended = served => {
                    if let Err(error) = ended {
                        debug!("connection to the page closed: {error}");
                    }
                }
                () = connection.closed() => debug!("connection to the page replaced by another"),
            }
            shares.remove(&connection);
        });
    }
}
