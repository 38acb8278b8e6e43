//! The connections of the web server, shared among the networks of its clients and among the browsers
//! in each network. When all connections are in use, the client that holds the most loses one.

use std::net::IpAddr;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::Notify;

/// How long a connection must transfer nothing before another one may replace it.
const MIN_IDLE: Duration = Duration::from_millis(250);

/// How long a connection must be open before another one may replace it, although it transfers data.
const MIN_AGE: Duration = Duration::from_secs(10);

/// All connections of a web server.
#[derive(Debug)]
pub(crate) struct Shares {
    max_connections: usize,
    max_streams: usize,
    connections: Mutex<Vec<Arc<Connection>>>,
}

/// A connection of a client.
#[derive(Debug)]
pub(crate) struct Connection {
    /// The network of the client.
    pub(crate) network: IpAddr,
    /// The browser that has sent the requests, known from its cookie.
    browser: OnceLock<String>,
    is_stream: AtomicBool,
    opened_at: Instant,
    /// The time from the beginning to the latest transfer, in ms.
    active_ms: AtomicU64,
    closed: Notify,
}

impl Connection {
    /// Records that data has been transferred.
    pub(crate) fn record_transfer(&self) {
        let elapsed = u64::try_from(self.opened_at.elapsed().as_millis()).unwrap_or(u64::MAX);
        self.active_ms.store(elapsed, Ordering::Relaxed);
    }

    /// Records which browser has sent a request.
    pub(crate) fn set_browser(&self, browser: &str) {
        self.browser.get_or_init(|| browser.into());
    }

    /// Waits until the connection must close, because another one needs its place.
    pub(crate) async fn closed(&self) {
        self.closed.notified().await;
    }

    fn last_active(&self) -> Instant {
        self.opened_at + Duration::from_millis(self.active_ms.load(Ordering::Relaxed))
    }

    fn is_stream(&self) -> bool {
        self.is_stream.load(Ordering::Relaxed)
    }
}

/// The numbers of connections from one network and of one browser in this network.
type Share = (usize, usize);

/// Returns the share of the client of a connection.
fn share<'c>(of: &Connection, all: impl Iterator<Item = &'c Arc<Connection>>) -> Share {
    let from_network = all.filter(|one| one.network == of.network);
    from_network.fold((0, 0), |(network, browser), one| {
        (network + 1, browser + usize::from(one.browser.get() == of.browser.get()))
    })
}

impl Shares {
    pub(crate) fn new(max_connections: usize, max_streams: usize) -> Self {
        Self { max_connections, max_streams, connections: Mutex::default() }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Arc<Connection>>> {
        self.connections.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a connection. If all are in use, it replaces one of the client that holds the most.
    /// Returns `None` if all connections of this client are in use.
    pub(crate) fn add(&self, network: IpAddr, now: Instant) -> Option<Arc<Connection>> {
        let mut connections = self.lock();
        if connections.len() >= self.max_connections {
            let max = connections.iter().map(|one| share(one, connections.iter())).max();
            let largest =
                || connections.iter().filter(|one| Some(share(one, connections.iter())) == max);
            let idle = largest().filter(|one| now.duration_since(one.last_active()) >= MIN_IDLE);
            let old = largest().filter(|one| now.duration_since(one.opened_at) >= MIN_AGE);
            let victim = idle
                .min_by_key(|one| one.last_active())
                .or_else(|| old.min_by_key(|one| one.opened_at))?;
            let victim = Arc::clone(victim);
            close(&mut connections, &victim);
        }
        let connection = Arc::new(Connection {
            network,
            browser: OnceLock::new(),
            is_stream: AtomicBool::new(false),
            opened_at: now,
            active_ms: AtomicU64::new(0),
            closed: Notify::new(),
        });
        connections.push(Arc::clone(&connection));
        Some(connection)
    }

    /// Removes a connection that has ended.
    pub(crate) fn remove(&self, connection: &Arc<Connection>) {
        self.lock().retain(|one| !Arc::ptr_eq(one, connection));
    }

    /// Lets a connection become an event stream. If there are as many streams as possible, it replaces
    /// one of a client that has more streams. Returns false if there is no such client.
    pub(crate) fn begin_stream(&self, connection: &Arc<Connection>) -> bool {
        let mut connections = self.lock();
        connection.is_stream.store(true, Ordering::Relaxed);
        let streams = || connections.iter().filter(|one| one.is_stream());
        if streams().count() > self.max_streams {
            let own = share(connection, streams());
            let larger = streams().filter(|one| share(one, streams()) > own);
            let victim = larger.max_by_key(|one| (share(one, streams()), one.opened_at));
            let Some(victim) = victim.cloned() else {
                connection.is_stream.store(false, Ordering::Relaxed);
                return false;
            };
            close(&mut connections, &victim);
        }
        true
    }
}

fn close(connections: &mut Vec<Arc<Connection>>, victim: &Arc<Connection>) {
    connections.retain(|one| !Arc::ptr_eq(one, victim));
    victim.closed.notify_one();
}

#[cfg(test)]
mod tests {
    use std::net::Ipv4Addr;

    use super::*;

    const ADDRESSES: [IpAddr; 2] =
        [IpAddr::V4(Ipv4Addr::LOCALHOST), IpAddr::V4(Ipv4Addr::new(192, 0, 2, 7))];

    fn is_open(shares: &Shares, connection: &Arc<Connection>) -> bool {
        shares.lock().iter().any(|one| Arc::ptr_eq(one, connection))
    }

    #[test]
    fn a_newcomer_replaces_an_idle_connection_of_the_largest_client() {
        let (shares, start) = (Shares::new(4, 2), Instant::now());
        let [many, few] = ADDRESSES;
        let lonely = shares.add(few, start).unwrap();
        let held = [0, 1, 2].map(|_| shares.add(many, start).unwrap());
        assert!(shares.add(few, start + MIN_IDLE / 2).is_none(), "all have just been used");
        let newcomer = shares.add(many, start + MIN_IDLE).unwrap();
        assert!(!is_open(&shares, &held[0]) && is_open(&shares, &lonely));
        held[1].active_ms.store(5000, Ordering::Relaxed);
        let later = start + Duration::from_secs(5);
        shares.add(few, later).unwrap();
        assert!(is_open(&shares, &held[1]), "it is active");
        assert_eq!(shares.lock().iter().filter(|one| one.network == few).count(), 2);
        assert!(is_open(&shares, &held[2]) ^ is_open(&shares, &newcomer));
        shares.remove(&lonely);
        assert!(shares.add(few, later).is_some(), "there is room");
    }

    #[test]
    fn active_connections_are_replaced_when_they_are_old() {
        let (shares, start) = (Shares::new(2, 1), Instant::now());
        for _ in 0..2 {
            let connection = shares.add(ADDRESSES[0], start).unwrap();
            connection.active_ms.store(u64::from(u32::MAX), Ordering::Relaxed);
        }
        assert!(shares.add(ADDRESSES[1], start + MIN_AGE / 2).is_none());
        assert!(shares.add(ADDRESSES[1], start + MIN_AGE).is_some());
    }

    #[test]
    fn a_browser_gets_its_stream_from_a_client_with_more_streams() {
        let (shares, start) = (Shares::new(100, 3), Instant::now());
        let open = |address, browser: Option<&str>| {
            let connection = shares.add(address, start).unwrap();
            if let Some(browser) = browser {
                connection.set_browser(browser);
            }
            (shares.begin_stream(&connection), connection)
        };
        let [here, elsewhere] = ADDRESSES;
        let anonymous = [0, 1, 2].map(|_| open(here, None).1);
        assert!(!open(here, None).0, "each client keeps what it has");
        let (accepted, browser) = open(here, Some("a"));
        assert!(accepted && !is_open(&shares, &anonymous[2]));
        let (accepted, other) = open(elsewhere, None);
        assert!(accepted && !is_open(&shares, &anonymous[1]));
        assert!(!open(here, Some("b")).0, "all clients have one stream");
        assert!([&browser, &other, &anonymous[0]].iter().all(|one| is_open(&shares, one)));
    }
}
