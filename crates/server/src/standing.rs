//! Who gives up its place when every place is taken.

use std::collections::HashMap;
use std::net::{IpAddr, Ipv6Addr};
use std::time::Instant;

use crate::limits::SILENCE;

/// What decides whether a connection keeps its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Standing {
    network: IpAddr,
    /// Whether it has sent a request that was worth a place.
    has_requested: bool,
    /// When it sent the last of those or, before the first, when it connected.
    since: Instant,
}

impl Standing {
    /// The standing of a peer that connects now.
    pub(crate) fn new(address: IpAddr, now: Instant) -> Self {
        Self { network: network(address), has_requested: false, since: now }
    }

    /// Records a request. A `ping` or a malformed request does not count: anybody can send those
    /// for ever without searching a maze.
    pub(crate) const fn record_request(&mut self, now: Instant) {
        (self.has_requested, self.since) = (true, now);
    }

    /// Records that the peer has read a part of its replies.
    pub(crate) const fn record_progress(&mut self, now: Instant) {
        if self.has_requested {
            self.since = now;
        }
    }
}

/// The network that shares one quota: an IPv4 address, or the 64 bits of IPv6 that one site owns.
fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => Ipv6Addr::from_bits(address.to_bits() >> 64 << 64).into(),
        address @ IpAddr::V4(_) => address,
    }
}

/// Chooses the connection whose place a newcomer gets, when every place is taken.
///
/// Connections without a request go first, then the one that has been silent for longest. Nobody
/// goes within [`SILENCE`], unless one network has more than half of all places and the newcomer
/// belongs to another.
pub(crate) fn evict<'s, T>(
    connections: impl Iterator<Item = (T, &'s Standing)> + Clone,
    newcomer: Option<IpAddr>,
    now: Instant,
) -> Option<T> {
    let rank = |(_, standing): &(T, &Standing)| (standing.has_requested, standing.since);
    let (lowest, standing) = connections.clone().min_by_key(rank)?;
    if now.saturating_duration_since(standing.since) >= SILENCE {
        return Some(lowest);
    }
    let mut counts = HashMap::new();
    for (_, standing) in connections.clone() {
        *counts.entry(standing.network).or_insert(0) += 1;
    }
    let places: usize = counts.values().sum();
    let (&crowd, _) = counts.iter().find(|&(_, count)| 2 * count > places)?;
    newcomer.filter(|&newcomer| network(newcomer) != crowd)?;
    let of_crowd = connections.filter(|(_, standing)| standing.network == crowd);
    of_crowd.min_by_key(rank).map(|(connection, _)| connection)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    const HERE: [u8; 4] = [127, 0, 0, 1];
    const ELSEWHERE: [u8; 4] = [192, 0, 2, 7];
    const SECOND: Duration = Duration::from_secs(1);

    /// Peers of [`HERE`] that connected at these seconds and sent their last request at those.
    fn peers(begin: Instant, times: &[(u32, Option<u32>)]) -> Vec<Standing> {
        let peer = |&(connected, requested): &(u32, Option<u32>)| {
            let mut standing = Standing::new(HERE.into(), begin + connected * SECOND);
            if let Some(requested) = requested {
                standing.record_request(begin + requested * SECOND);
            }
            standing
        };
        times.iter().map(peer).collect()
    }

    fn evicted(peers: &[Standing], newcomer: [u8; 4], now: Instant) -> Option<usize> {
        evict(peers.iter().enumerate(), Some(newcomer.into()), now)
    }

    #[test]
    fn a_peer_that_has_requested_outranks_one_that_has_not() {
        let begin = Instant::now();
        // A mouse that has thought since second 1, beside two connections that never asked.
        let peers = peers(begin, &[(0, Some(1)), (8, None), (7, None)]);
        for second in 0..17 {
            assert_eq!(evicted(&peers, HERE, begin + second * SECOND), None, "second {second}");
        }
        for second in 17..100 {
            assert_eq!(evicted(&peers, HERE, begin + second * SECOND), Some(2), "second {second}");
        }
    }

    #[test]
    fn among_mice_the_one_that_was_silent_for_longest_goes() {
        let begin = Instant::now();
        let mut peers = peers(begin, &[(0, Some(5)), (0, Some(3)), (0, Some(9))]);
        assert_eq!(evicted(&peers, HERE, begin + 12 * SECOND), None);
        assert_eq!(evicted(&peers, HERE, begin + 13 * SECOND), Some(1));
        peers[1].record_progress(begin + 12 * SECOND);
        assert_eq!(evicted(&peers, HERE, begin + 14 * SECOND), None);
        assert_eq!(evicted(&peers, HERE, begin + 15 * SECOND), Some(0));
        assert_eq!(evicted(&[], HERE, begin), None);
    }

    #[test]
    fn replies_that_are_read_do_not_make_a_mouse() {
        let begin = Instant::now();
        let mut peers = peers(begin, &[(0, None), (1, None)]);
        peers[0].record_progress(begin + 9 * SECOND);
        assert_eq!(evicted(&peers, HERE, begin + 11 * SECOND), Some(0));
    }

    #[test]
    fn a_network_with_more_than_half_of_the_places_makes_room_for_others() {
        let begin = Instant::now();
        let mut peers = peers(begin, &[(0, Some(3)), (0, Some(2)), (1, Some(4))]);
        peers.extend([Standing::new(ELSEWHERE.into(), begin); 2]);
        assert_eq!(evicted(&peers, ELSEWHERE, begin + 4 * SECOND), Some(1));
        assert_eq!(evicted(&peers, HERE, begin + 4 * SECOND), None);
        assert_eq!(evict(peers.iter().enumerate(), None, begin + 4 * SECOND), None);
        // Half of the places is not too much.
        peers.push(Standing::new([192, 0, 2, 8].into(), begin));
        assert_eq!(evicted(&peers, ELSEWHERE, begin + 4 * SECOND), None);
    }

    #[test]
    fn a_site_of_ipv6_is_one_network() {
        let network = |text: &str| network(text.parse().unwrap());
        assert_eq!(network("2001:db8:0:1::7"), network("2001:db8:0:1:ffff::8"));
        assert_ne!(network("2001:db8:0:1::7"), network("2001:db8:0:2::7"));
        assert_eq!(network("::ffff:127.0.0.1"), network("127.0.0.1"));
        assert_ne!(network("127.0.0.1"), network("127.0.0.2"));
    }
}
