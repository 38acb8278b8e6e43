//! The web server: where it listens, whom it serves, how it stops.

use std::fmt::Write;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use axum::{Router, middleware};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use mmsim_server::{BindError, listen};
use tokio::net::TcpListener;
use tokio::runtime::{self, Runtime};
use tokio::sync::{Semaphore, oneshot};
use tokio::time::sleep;
use tower_http::compression::CompressionLayer;
use tower_http::compression::predicate::{
    DefaultPredicate, NotForContentType, Predicate, SizeAbove,
};
use tracing::{debug, warn};

use crate::access::{Access, guard};
use crate::transfer::Connection;
use crate::{Limits, ViewerConfig, api, work};

/// What is shorter is not worth packing, in bytes: figures that are asked for all the time.
const WORTH_PACKING: u64 = 4096;

/// When the system could not give a connection for want of descriptors, it is asked again after
/// so long.
const ACCEPT_AGAIN: Duration = Duration::from_millis(250);

/// A web server that listens already and serves once it is given something to show.
///
/// ```
/// use mmsim_server::{Server, Simulation};
/// use mmsim_viewer::{ViewerConfig, Viewer};
/// let maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let server = Server::bind("127.0.0.1", 0)?;
/// let viewer = Viewer::bind("127.0.0.1", 0)?;
/// let config = ViewerConfig::default().with_live(&server, "small.txt".as_ref());
/// let server = server.spawn(Simulation::new("small", maze));
/// let viewer = viewer.spawn(show)?;
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

/// A web server on a thread of its own, which serves until it is stopped or the process ends.
pub struct Serving {
    address: String,
    stop: oneshot::Sender<()>,
    thread: JoinHandle<()>,
}

impl Viewer {
    /// Listens on a port of this machine; port 0 takes a free one. If other machines can reach it
    /// there, a token is made that a browser has to show.
    ///
    /// # Errors
    /// The port is in use, or the host is not one of this machine's.
    pub fn bind(host: &str, port: u16) -> Result<Self, BindError> {
        let failed = |source| BindError::Listen { host: host.into(), port, source };
        let listener = listen(host, port)?;
        let local = listener.local_addr().map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let is_loopback = local.ip().to_canonical().is_loopback();
        let token = if is_loopback { None } else { Some(token().map_err(failed)?) };
        let access = Access::new(token, local.port());
        Ok(Self { listener, access, local, limits: Limits::default() })
    }

    /// Replaces the limits.
    pub fn with_limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    /// Where the page is, such as `http://127.0.0.1:6575`, with the token if there is one.
    pub fn address(&self) -> String {
        let Self { access, local, .. } = self;
        match access.query() {
            query if query.is_empty() => format!("http://{local}"),
            query => format!("http://{local}/{query}"),
        }
    }

    /// Serves on a thread of its own.
    ///
    /// # Errors
    /// The system has no thread or event queue left.
    pub fn spawn(self, config: ViewerConfig) -> io::Result<Serving> {
        let (address, (stop, stopped)) = (self.address(), oneshot::channel());
        let runtime = runtime::Builder::new_current_thread()
            .enable_all()
            .max_blocking_threads(work::THREADS)
            .build()?;
        let (app, limits) = (app(config, self.access, self.limits), self.limits);
        let listener = {
            let _inside = runtime.enter();
            TcpListener::from_std(self.listener)?
        };
        let thread = thread::Builder::new()
            .name("viewer".into())
            .spawn(move || run(runtime, listener, app, limits, stopped))?;
        Ok(Serving { address, stop, thread })
    }
}

impl Serving {
    /// Where the page is, with the token if there is one.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Stops; whoever is connected is cut off.
    pub fn stop(self) {
        // If nobody listens any more it has stopped.
        let _ = self.stop.send(());
        let _ = self.thread.join();
    }
}

fn app(config: ViewerConfig, access: Access, limits: Limits) -> Router {
    let packed = DefaultPredicate::new()
        .and(SizeAbove::new(WORTH_PACKING))
        .and(NotForContentType::const_new("application/octet-stream"));
    api::router(Arc::new(config.into_state(limits)))
        .layer(CompressionLayer::new().compress_when(packed))
        .layer(middleware::from_fn_with_state(Arc::new(access), guard))
}

fn run(
    runtime: Runtime,
    listener: TcpListener,
    app: Router,
    limits: Limits,
    stopped: oneshot::Receiver<()>,
) {
    runtime.block_on(async {
        tokio::select! {
            () = accept(listener, app, limits) => {}
            // Nobody can stop it any more once the other end is dropped.
            Ok(()) = stopped => {}
        }
    });
    // Not for what takes a while.
    runtime.shutdown_background();
}

/// Accepts connections as there is room, each served in its turn.
async fn accept(listener: TcpListener, app: Router, limits: Limits) {
    let room = Arc::new(Semaphore::new(limits.connections));
    let mut warned = false;
    loop {
        let Ok(place) = Arc::clone(&room).acquire_owned().await else { return };
        let stream = match listener.accept().await {
            Ok((stream, _)) => stream,
            Err(error) => {
                // Once is enough for whoever reads it: without descriptors this comes again and again.
                if !std::mem::replace(&mut warned, true) {
                    warn!("cannot accept a connection to the page: {error}");
                }
                sleep(ACCEPT_AGAIN).await;
                continue;
            }
        };
        // Small replies are wanted at once.
        let _ = stream.set_nodelay(true);
        let service = TowerToHyperService::new(app.clone());
        tokio::spawn(async move {
            let connection = http1::Builder::new()
                .timer(TokioTimer::new())
                .header_read_timeout(limits.header_time)
                .serve_connection(TokioIo::new(Connection::new(stream, limits)), service);
            if let Err(error) = connection.await {
                debug!("a viewer's connection ended: {error}");
            }
            drop(place);
        });
    }
}

/// 128 bits that nobody guesses, as text.
fn token() -> io::Result<String> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(io::Error::other)?;
    Ok(bytes.iter().fold(String::new(), |mut token, byte| {
        // Writing into a string cannot fail.
        let _ = write!(token, "{byte:02x}");
        token
    }))
}
