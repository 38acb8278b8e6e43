//! Tests of the planner: laws, the enumeration of all runs in small mazes, and allocations.

mod allocations;
mod cases;
mod enumeration;
mod laws;
