//! Encodes and decodes messages with the wire codec, without a socket.
//!
//! Use the codec with your own transport, such as a serial line to a mouse. The codec does not
//! allocate, so the same calls work in firmware.

use mmsim_protocol::{
    Cell, Heading, KnownMaze, MAX_STATE_BYTES, MapState, MazeSize, Order, Pose, Reply, Request,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let size = MazeSize::CLASSIC;
    let pose = Pose::new(Cell::new(0, 0), Heading::North);
    let mut map = KnownMaze::new(size, pose.cell, size.central_cells());
    // The buffer is large enough for any request.
    let mut buffer = [0; MAX_STATE_BYTES];

    let length = Request::Walls(pose).encode(&mut buffer)?;
    println!("walls request, {length} bytes: {}", buffer[..length].escape_ascii());

    // A reply can be decoded without the request. Here are three examples.
    for message in [&[1, 0, 1][..], b"ok", b"error: expected one frame, found 2"] {
        print!("reply {}: ", message.escape_ascii());
        match Reply::decode(message)? {
            Reply::Walls(around) => {
                println!("{around:?}");
                map.observe(pose, around)?;
            }
            Reply::Error(reason) => println!("refused, {reason}"),
            reply => println!("{reply:?}"),
        }
    }

    // A weight is any number per cell; here it is the distance to the south-west corner.
    let weight = |cell: Cell| u16::from(cell.x) + u16::from(cell.y);
    let length = MapState::new(pose, &map, weight, Order::F).encode(&mut buffer)?;
    println!("state, {length} bytes: {} ...", buffer[..21].escape_ascii());

    // Decode the state, as a simulator or viewer does.
    let Request::State(state) = Request::decode(&buffer[..length], size)? else {
        return Err("expected a state".into());
    };
    let flags = state.cell_walls(pose.cell).ok_or("expected a cell of the maze")?;
    println!("the mouse is in {}, heading {}", state.pose().cell, state.pose().heading);
    println!("the mouse has visited this cell: {}", flags.visited());
    for heading in Heading::ALL {
        println!("the mouse knows of a wall to the {heading}: {}", flags.wall(heading));
    }
    Ok(())
}
