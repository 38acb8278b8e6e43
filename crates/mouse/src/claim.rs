//! Decides which client of a run is its mouse.

use std::mem;
use std::time::{Duration, Instant};

use mmsim_zmtp::ClientId;

/// The time that a new connection of the mouse waits for the end of the previous one, which the
/// operating system may report later.
const RECONNECT_TIME: Duration = Duration::from_secs(1);

/// The time after the end of the mouse's connection before another client of the public address can
/// be the mouse. If the mouse has exited, its run ends within this time.
const VACANT_TIME: Duration = Duration::from_secs(1);

/// The clients of one run that have used an address, and the one that is the mouse.
#[derive(Debug)]
pub(crate) struct Claims {
    /// A client that connected before this one is not the mouse.
    first: ClientId,
    /// True if a client has used the public address.
    is_public_used: bool,
    /// True if a client has used the address of the run. Clients of the public address then only read.
    is_private_used: bool,
    mouse: Option<Mouse>,
}

/// The mouse or, before a client has sent `S`, the client that has written last.
#[derive(Debug)]
struct Mouse {
    client: ClientId,
    has_state: bool,
    /// The time at which the connection ended, and a client that connected then.
    left: Option<(Instant, ClientId)>,
}

/// What a client may do during a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// The client is the mouse, or may become the mouse.
    Mouse,
    /// Like `Mouse`, but what other clients have sent during the run must be deleted first.
    Successor,
    /// The client may read. At this time, it may have become the mouse.
    Waiting(Instant),
    /// The client may read.
    Other,
}

impl Claims {
    /// Begins a run. Its mouse connects after this.
    pub(crate) fn new() -> Self {
        let first = ClientId::unique();
        Self { first, is_public_used: false, is_private_used: false, mouse: None }
    }

    /// Decides the role of a client that sends a request to the address of the run, if `is_private` is
    /// true, or to the public address. A write may make the client the mouse.
    pub(crate) fn role(
        &mut self,
        client: ClientId,
        is_private: bool,
        is_write: bool,
        now: Instant,
    ) -> Role {
        if client < self.first || self.is_private_used && !is_private {
            return Role::Other;
        }
        self.is_public_used |= !is_private;
        let is_first = is_private && !mem::replace(&mut self.is_private_used, true);
        let role = match &mut self.mouse {
            _ if is_first && self.is_public_used => Role::Successor,
            None => Role::Mouse,
            Some(mouse) if mouse.client == client => return Role::Mouse,
            // All clients of the address of the run belong to the mouse.
            Some(mouse) if !is_write && (is_private || !mouse.has_state) => return Role::Mouse,
            Some(_) if !is_write => return Role::Other,
            Some(mouse) if !mouse.has_state => {
                if is_private {
                    Role::Mouse
                } else {
                    Role::Successor
                }
            }
            Some(mouse) => match mouse.left {
                None if is_private => return Role::Waiting(now + RECONNECT_TIME),
                Some((at, next)) if is_private || client > next => {
                    if !is_private && now < at + VACANT_TIME {
                        return Role::Waiting(at + VACANT_TIME);
                    }
                    (mouse.client, mouse.left) = (client, None);
                    return Role::Mouse;
                }
                _ => return Role::Other,
            },
        };
        self.mouse = is_write.then_some(Mouse { client, has_state: false, left: None });
        role
    }

    /// Records that the mouse has sent a valid state, so that no other client can become the mouse.
    pub(crate) const fn add_state(&mut self) {
        if let Some(mouse) = &mut self.mouse {
            mouse.has_state = true;
        }
    }

    /// Records that the connection of a client has ended.
    pub(crate) fn disconnect(&mut self, client: ClientId, now: Instant) {
        if let Some(mouse) = self.mouse.as_mut().filter(|mouse| mouse.client == client) {
            mouse.left = Some((now, ClientId::unique()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_client_of_the_public_address_succeeds_the_mouse_only_if_it_connects_later() {
        let (mut claims, now) = (Claims::new(), Instant::now());
        let [mouse, early] = [(); 2].map(|()| ClientId::unique());
        assert_eq!(claims.role(mouse, false, true, now), Role::Mouse);
        claims.add_state();
        assert_eq!(claims.role(early, false, true, now), Role::Other);
        claims.disconnect(mouse, now);
        let late = ClientId::unique();
        let vacant = now + VACANT_TIME;
        assert_eq!(claims.role(late, false, true, now), Role::Waiting(vacant));
        assert_eq!(claims.role(early, false, true, vacant), Role::Other);
        assert_eq!(claims.role(late, false, true, vacant), Role::Mouse);
        assert_eq!(claims.role(early, false, false, vacant), Role::Other);
    }

    #[test]
    fn the_first_request_to_the_address_of_the_run_ends_all_claims_of_the_public_address() {
        let now = Instant::now();
        for is_write in [false, true] {
            let mut claims = Claims::new();
            let [public, private] = [(); 2].map(|()| ClientId::unique());
            assert_eq!(claims.role(public, false, is_write, now), Role::Mouse);
            assert_eq!(claims.role(private, true, false, now), Role::Successor);
            assert_eq!(claims.role(public, false, is_write, now), Role::Other);
            assert_eq!(claims.role(private, true, true, now), Role::Mouse);
        }
    }

    #[test]
    fn the_first_state_decides_among_clients_of_the_same_address() {
        let now = Instant::now();
        for is_private in [false, true] {
            let mut claims = Claims::new();
            let clients = [(); 3].map(|()| ClientId::unique());
            let others = if is_private { Role::Mouse } else { Role::Successor };
            let roles = clients.map(|client| claims.role(client, is_private, true, now));
            assert_eq!(roles, [Role::Mouse, others, others]);
            claims.add_state();
            let role = claims.role(clients[0], is_private, true, now);
            let refused =
                if is_private { Role::Waiting(now + RECONNECT_TIME) } else { Role::Other };
            assert_eq!(role, refused);
            let reads = if is_private { Role::Mouse } else { Role::Other };
            assert_eq!(claims.role(clients[0], is_private, false, now), reads);
            assert_eq!(claims.role(clients[2], is_private, true, now), Role::Mouse);
        }
    }
}
