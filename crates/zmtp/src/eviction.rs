//! Decides which connection is closed when a new client connects to a full server.

use std::collections::HashMap;
use std::net::{IpAddr, Ipv6Addr};
use std::time::{Duration, Instant};

/// The activity of a client, which determines whether its connection may be closed to make room for
/// another client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Activity {
    network: IpAddr,
    /// True if the client has sent at least one request that counts as activity.
    has_requested: bool,
    /// The time of the client's latest activity. Initially, this is the time at which the client
    /// connected.
    last_active: Instant,
}

impl Activity {
    /// Creates the activity record of a client that connects at the time `now`.
    pub(crate) fn new(address: IpAddr, now: Instant) -> Self {
        Self { network: network(address), has_requested: false, last_active: now }
    }

    /// Records a request that counts as activity.
    pub(crate) const fn record_request(&mut self, now: Instant) {
        (self.has_requested, self.last_active) = (true, now);
    }

    /// Records that the client has read some of its replies.
    pub(crate) const fn record_progress(&mut self, now: Instant) {
        if self.has_requested {
            self.last_active = now;
        }
    }
}

/// Returns the network of an address. The network is the IPv4 address itself, or the /64 prefix of
/// the IPv6 address. IPv6 addresses with the same /64 prefix belong to one subnet.
///
/// ```
/// use mmsim_zmtp::network;
/// let [one, other] = ["2001:db8::1", "2001:db8::2"].map(|text| text.parse().unwrap());
/// assert_eq!(network(one), network(other));
/// ```
pub fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => Ipv6Addr::from_bits(address.to_bits() >> 64 << 64).into(),
        address @ IpAddr::V4(_) => address,
    }
}

/// Chooses the connection to close when a new client connects to a full server.
///
/// The function chooses the connection that has been silent the longest among those without
/// activity (see [`Service::answer`](crate::Service::answer)) or, if there are none, among all
/// connections. A connection that has been silent for less than `silence` is closed only if more
/// than half of all connections belong to its network and the new client belongs to another network.
pub(crate) fn choose_evicted<'s, T>(
    connections: impl Iterator<Item = (T, &'s Activity)> + Clone,
    newcomer: Option<IpAddr>,
    silence: Duration,
    now: Instant,
) -> Option<T> {
    let rank = |(_, activity): &(T, &Activity)| (activity.has_requested, activity.last_active);
    let (lowest, activity) = connections.clone().min_by_key(rank)?;
    if now.saturating_duration_since(activity.last_active) >= silence {
        return Some(lowest);
    }
    let mut counts = HashMap::new();
    for (_, activity) in connections.clone() {
        *counts.entry(activity.network).or_insert(0) += 1;
    }
    let places: usize = counts.values().sum();
    let (&majority, _) = counts.iter().find(|&(_, count)| 2 * count > places)?;
    newcomer.filter(|&newcomer| network(newcomer) != majority)?;
    let in_majority = connections.filter(|(_, activity)| activity.network == majority);
    in_majority.min_by_key(rank).map(|(connection, _)| connection)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SILENCE: Duration = Duration::from_secs(10);

    const HERE: [u8; 4] = [127, 0, 0, 1];
    const ELSEWHERE: [u8; 4] = [192, 0, 2, 7];
    const SECOND: Duration = Duration::from_secs(1);

    /// Returns the activity of clients with the address [`HERE`]. Each element of `times` contains
    /// the time at which a client connected and the time of its latest request, if any, in seconds
    /// after `begin`.
    fn connections(begin: Instant, times: &[(u32, Option<u32>)]) -> Vec<Activity> {
        let connection = |&(connected, requested): &(u32, Option<u32>)| {
            let mut activity = Activity::new(HERE.into(), begin + connected * SECOND);
            if let Some(requested) = requested {
                activity.record_request(begin + requested * SECOND);
            }
            activity
        };
        times.iter().map(connection).collect()
    }

    fn evicted(connections: &[Activity], newcomer: [u8; 4], now: Instant) -> Option<usize> {
        choose_evicted(connections.iter().enumerate(), Some(newcomer.into()), SILENCE, now)
    }

    #[test]
    fn connection_with_a_request_outranks_one_without() {
        let begin = Instant::now();
        // One client has been silent since second 1. Two clients have never sent a request.
        let connections = connections(begin, &[(0, Some(1)), (8, None), (7, None)]);
        for second in 0..17 {
            assert_eq!(
                evicted(&connections, HERE, begin + second * SECOND),
                None,
                "second {second}"
            );
        }
        for second in 17..100 {
            assert_eq!(
                evicted(&connections, HERE, begin + second * SECOND),
                Some(2),
                "second {second}"
            );
        }
    }

    #[test]
    fn longest_silent_connection_is_evicted() {
        let begin = Instant::now();
        let mut connections = connections(begin, &[(0, Some(5)), (0, Some(3)), (0, Some(9))]);
        assert_eq!(evicted(&connections, HERE, begin + 12 * SECOND), None);
        assert_eq!(evicted(&connections, HERE, begin + 13 * SECOND), Some(1));
        connections[1].record_progress(begin + 12 * SECOND);
        assert_eq!(evicted(&connections, HERE, begin + 14 * SECOND), None);
        assert_eq!(evicted(&connections, HERE, begin + 15 * SECOND), Some(0));
        assert_eq!(evicted(&[], HERE, begin), None);
    }

    #[test]
    fn reading_replies_without_a_request_is_no_activity() {
        let begin = Instant::now();
        let mut connections = connections(begin, &[(0, None), (1, None)]);
        connections[0].record_progress(begin + 9 * SECOND);
        assert_eq!(evicted(&connections, HERE, begin + 11 * SECOND), Some(0));
    }

    #[test]
    fn network_with_more_than_half_of_the_connections_makes_room_for_others() {
        let begin = Instant::now();
        let mut connections = connections(begin, &[(0, Some(3)), (0, Some(2)), (1, Some(4))]);
        connections.extend([Activity::new(ELSEWHERE.into(), begin); 2]);
        assert_eq!(evicted(&connections, ELSEWHERE, begin + 4 * SECOND), Some(1));
        assert_eq!(evicted(&connections, HERE, begin + 4 * SECOND), None);
        let four = begin + 4 * SECOND;
        assert_eq!(choose_evicted(connections.iter().enumerate(), None, SILENCE, four), None);
        // A network may have half of all connections.
        connections.push(Activity::new([192, 0, 2, 8].into(), begin));
        assert_eq!(evicted(&connections, ELSEWHERE, begin + 4 * SECOND), None);
    }

    #[test]
    fn ipv6_network_has_64_bits() {
        let network = |text: &str| network(text.parse().unwrap());
        assert_eq!(network("2001:db8:0:1::7"), network("2001:db8:0:1:ffff::8"));
        assert_ne!(network("2001:db8:0:1::7"), network("2001:db8:0:2::7"));
        assert_eq!(network("::ffff:127.0.0.1"), network("127.0.0.1"));
        assert_ne!(network("127.0.0.1"), network("127.0.0.2"));
    }
}
