//! A mouse that sends incompressible states.

use mmsim_maze::WyRand;
use mmsim_tests::connect_to;

/// Returns an incompressible state for a classic maze, different for each number.
pub fn state(number: u64) -> Vec<u8> {
    let mut rng = WyRand::new(number);
    let mut noise = || rng.next_u64().to_be_bytes()[0];
    let mut state = vec![0; 518];
    state.fill_with(&mut noise);
    state[..5].copy_from_slice(&[b'S', noise() % 16, noise() % 16, b'N', b'C']);
    state[261] = b'F';
    state
}

/// Sends at most `max` states, in batches, until the server refuses a state. Returns the number of
/// acknowledged states, and the error message if a state was refused.
pub fn send_until_refused(address: &str, from: u64, max: u64) -> (u64, Option<String>) {
    let socket = connect_to(address, zmq::DEALER);
    let (mut sent, mut acknowledged, mut refusal) = (from, 0, None);
    for answered in from..from + max {
        while refusal.is_none() && sent < (answered + 100).min(from + max) {
            socket.send_multipart([Vec::new(), state(sent)], 0).unwrap();
            sent += 1;
        }
        if answered == sent {
            break;
        }
        let reply = socket.recv_multipart(0).unwrap().swap_remove(1);
        if reply == b"ok" {
            acknowledged += 1;
        } else if refusal.is_none() {
            refusal = Some(String::from_utf8(reply).unwrap());
        }
    }
    (acknowledged, refusal)
}
