//! The serial port of QEMU's boards. For another board, use the driver of its HAL.
#![allow(unsafe_code)] // for the registers

use crate::zmtp::Port;

/// The first serial port of the board.
pub(crate) struct Uart(());

/// The registers of the UART in Arm's Cortex-M System Design Kit, as on the board MPS2.
#[cfg(not(nrf51))]
mod registers {
    pub(super) const DATA: usize = 0x4000_4000;
    pub(super) const STATE: usize = 0x4000_4004;
    pub(super) const TRANSMIT_BUFFER_FULL: u32 = 1;
    pub(super) const RECEIVE_BUFFER_FULL: u32 = 1 << 1;
    /// The smallest divider of the clock, then the transmitter and the receiver.
    pub(super) const SET_UP: [(usize, u32); 2] = [(0x4000_4010, 16), (0x4000_4008, 0b11)];
}

/// The registers of the UART in the nRF51, as on the micro:bit.
#[cfg(nrf51)]
mod registers {
    pub(super) const RECEIVED: usize = 0x4000_2108;
    pub(super) const SENT: usize = 0x4000_211c;
    pub(super) const DATA_IN: usize = 0x4000_2518;
    pub(super) const DATA_OUT: usize = 0x4000_251c;
    /// The port, then the receiver and the transmitter.
    pub(super) const SET_UP: [(usize, u32); 3] =
        [(0x4000_2500, 4), (0x4000_2000, 1), (0x4000_2008, 1)];
}

use registers::*;

impl Uart {
    pub(crate) fn new() -> Self {
        SET_UP.into_iter().for_each(|(register, value)| write(register, value));
        Self(())
    }
}

#[cfg(not(nrf51))]
impl Port for Uart {
    fn send(&mut self, byte: u8) {
        while read(STATE) & TRANSMIT_BUFFER_FULL != 0 {}
        write(DATA, byte.into());
    }

    fn receive(&mut self) -> u8 {
        while read(STATE) & RECEIVE_BUFFER_FULL == 0 {}
        read(DATA) as u8
    }
}

#[cfg(nrf51)]
impl Port for Uart {
    fn send(&mut self, byte: u8) {
        write(DATA_OUT, byte.into());
        while read(SENT) == 0 {}
        write(SENT, 0);
    }

    fn receive(&mut self) -> u8 {
        while read(RECEIVED) == 0 {}
        write(RECEIVED, 0);
        read(DATA_IN) as u8
    }
}

fn write(register: usize, value: u32) {
    // SAFETY: the address is that of a register, and nothing else uses the port.
    unsafe { (register as *mut u32).write_volatile(value) }
}

fn read(register: usize) -> u32 {
    // SAFETY: see `write`.
    unsafe { (register as *const u32).read_volatile() }
}
