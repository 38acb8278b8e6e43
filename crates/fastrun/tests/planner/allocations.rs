//! A planner that has planned once needs no further memory.

use crate::cases::{Case, any_case};
use mmsim_fastrun::{Planner, Vehicle};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;

#[test]
fn a_second_plan_allocates_nothing() {
    let mut runner = TestRunner::deterministic();
    let mut case = |side| any_case(side).new_tree(&mut runner).unwrap().current();
    let cases: Vec<Case> =
        (0..100).map(|index| case(if index % 4 == 0 { 32 } else { 16 })).collect();
    for name in Vehicle::PRESETS {
        let mut planner = Planner::new(Vehicle::preset(name).unwrap());
        let mut plan_all = || {
            let mut is_ok =
                |Case { walls, start, goals }: &Case| planner.plan(walls, *start, goals).is_ok();
            cases.iter().filter(|case| is_ok(case)).count()
        };
        let solved = plan_all();
        assert!(solved > 10, "{solved} cases have a run");
        let found = allocation_counter::measure(|| assert_eq!(plan_all(), solved));
        assert_eq!(found.count_total, 0, "{name}");
    }
}
