//! `mmsim fast-run`: times, tables, JSON, CSV and vehicle files.

mod harness;

use std::fs;

use harness::{Home, recorded};
use serde_json::{Value, json};

const MAZE: &str = "\
o---o---o---o
|         G |
o   o   o---o
| S |       |
o---o---o---o
";
const CLOSED: &str = "o---o---o\n| S | G |\no---o---o\n";
const CUT_OFF: &str = "o---o---o---o\n| S     | G |\no---o---o---o\n";

/// Returns a maze of one row with a start in the west and a goal in the east.
fn corridor(cells: usize) -> String {
    let wall = format!("{}o\n", "o---".repeat(cells));
    format!("{wall}| S {}  G |\n{wall}", "    ".repeat(cells - 2))
}

#[test]
fn the_fastest_run_is_described() {
    let home = Home::new();
    let ended = home.run(&["fast-run", "harbour"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    insta::assert_snapshot!(ended.stdout, @r"
    01-harbour.txt: fastest run of expert
    time      4.200 s from rest to rest, 3.925 s from gate to gate
    distance  7.956 m, 52 cells
    speed     mean 1.894 m/s, top 2.500 m/s
    turns     15: 5 l90, 5 45in, 5 45out
    run       N 0 45inR@1400 0 45outL@1700 0 45inL@1400 0 45outR@1700 10 l90R@1600 4
              45inR@1400 3 45outR@1700 0 45inL@1400 6 45outR@1700 2 l90L@1600 6
              l90L@1600 2 45inL@1400 3 45outL@1700 4 l90R@1600 2 l90L@1400 0
    ");
    let ended = home.run(&["fast-run", "first steps", "--vehicle", "ares", "--explain"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    insta::assert_snapshot!(ended.stdout, @r"
    training-first-steps.txt: fastest run of ares
    time      2.167 s from rest to rest, 1.805 s from gate to gate
    distance  2.387 m, 16 cells
    speed     mean 1.102 m/s, top 2.872 m/s
    turns     4: 2 45in, 2 135out
    run       N 6 45inR@850 5 135outR@650 0 45inL@850 0 135outR@650 0

              steps     mm  entry mm/s  top mm/s  exit mm/s     g       s  total s
    straight      6  622.9           0      2567        850        0.4284   0.4284
    45inR            100.0         850       850        850  0.87  0.1176   0.5461
    diagonal      5  767.6         850      2872        650        0.4244   0.9705
    135outR          220.0         650       650        650  0.69  0.3385   1.3089
    straight      0  109.3         650      1291        850        0.1081   1.4171
    45inL            100.0         850       850        850  0.87  0.1176   1.5347
    diagonal      0  131.2         850      1373        650        0.1245   1.6593
    135outR          220.0         650       650        650  0.69  0.3385   1.9977
    straight      0  116.5         650      1173          0        0.1696   2.1673
    ");
}

#[test]
fn vehicles_and_routes_are_compared_in_a_table() {
    let home = Home::new();
    let vehicles = ["--vehicle", "ukmars", "--vehicle", "expert", "--vehicle", "ukmars"];
    let ended = home.run(&[&["fast-run", "harbour"], &vehicles[..]].concat());
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    insta::assert_snapshot!(ended.stdout, @r"
    maze            vehicle      time  gate to gate  distance  slalom turns
    01-harbour.txt  ukmars   13.056 s      12.437 s   8.791 m            27
    01-harbour.txt  expert    4.200 s       3.925 s   7.956 m            15
    ");
    let ended = home.run(&[
        "fast-run",
        "two roads",
        "left bank",
        "--route",
        "fastest,fewest-cells,fewest-turns",
    ]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    insta::assert_snapshot!(ended.stdout, @r"
    maze
      vehicle  route             time  gate to gate  distance  slalom turns     loss
    10-two-roads.txt
      expert   fastest        3.642 s       3.361 s   6.608 m            13   0.00 %
      expert   fewest-cells   3.642 s       3.361 s   6.608 m            13   0.00 %
      expert   fewest-turns   4.503 s       4.233 s   9.273 m            11  23.64 %
    09-left-bank.txt
      expert   fastest        4.286 s       4.013 s   8.218 m            12   0.00 %
      expert   fewest-cells   4.472 s       4.198 s   8.316 m            14   4.33 %
      expert   fewest-turns   4.472 s       4.198 s   8.316 m            14   4.33 %

    mean of 2 mazes
      expert   fastest        3.964 s       3.687 s   7.413 m          12.5   0.00 %
      expert   fewest-cells   4.057 s       3.780 s   7.462 m          13.5   2.17 %
      expert   fewest-turns   4.487 s       4.216 s   8.795 m          12.5  13.98 %
    ");
    let ended = home.run(&["fast-run", "two roads", "--route", "fewest-turns"]);
    insta::assert_snapshot!(ended.stdout, @r"
    10-two-roads.txt: fastest run of expert along a route with the fewest turns
    time      4.503 s from rest to rest, 4.233 s from gate to gate, loss 23.64 %
    distance  9.273 m, 56 cells
    speed     mean 2.059 m/s, top 2.500 m/s
    turns     11: 3 l90, 4 45in, 4 45out
    run       N 16 45inR@1400 0 45outL@1700 4 l90R@1600 22 45inR@1400 1 45outR@1700
              20 l90R@1600 0 45inR@1400 4 45outL@1700 2 l90R@1600 2 45inL@1400 0
              45outR@1300 0
    ");
}

#[test]
fn mazes_without_a_run_are_listed_and_unreadable_ones_are_skipped() {
    let home = Home::new();
    home.write("mazes/a.txt", MAZE);
    home.write("mazes/closed.txt", CLOSED);
    home.write("mazes/cut/off.txt", CUT_OFF);
    home.write("mazes/damaged.txt", "o---o\n| S \no---o\n");
    home.write("mazes/z.txt", corridor(5));
    let ended = home.run(&["fast-run", "mazes", "mazes/a.txt"]);
    assert_eq!(ended.code, Some(1));
    insta::assert_snapshot!(ended.stdout, @r"
    maze
      vehicle      time  gate to gate  distance  slalom turns
    mazes/a.txt
      expert    0.461 s       0.197 s   0.574 m             1
    mazes/closed.txt
      expert   goal unreachable: the start at (0, 0) has walls on all sides
    mazes/cut/off.txt
      expert   goal unreachable: walls enclose every goal cell
    mazes/z.txt
      expert    0.471 s       0.219 s   0.810 m             0

    mean of 2 mazes
      expert    0.466 s       0.208 s   0.692 m           0.5
    2 mazes without a run
    ");
    let stderr = ended.stderr;
    assert!(stderr.starts_with("mmsim: ") && stderr.contains("damaged.txt: line 2"), "{stderr}");
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
    let ended = home.run(&["fast-run", "mazes/a.txt", "mazes/z.txt"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    let ended = home.run(&["fast-run", "mazes/closed.txt", "mazes/cut", "--explain"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(1), ""));
    insta::assert_snapshot!(ended.stdout, @r"
        mazes/closed.txt: expert: goal unreachable: the start at (0, 0) has walls on all
          sides

        mazes/cut/off.txt: expert: goal unreachable: walls enclose every goal cell
        ");
    let ended = home.run(&["fast-run", "mazes/closed.txt"]);
    assert_eq!((ended.code, &ended.stdout[..]), (Some(1), ""));
    insta::assert_snapshot!(ended.stderr, @"mmsim: mazes/closed.txt: goal unreachable: the start at (0, 0) has walls on all sides");
    for arguments in [&["fast-run", "mazes/damaged.txt"][..], &["fast-run", "none", "--csv", "-"]] {
        let ended = home.run(arguments);
        assert_eq!((ended.code, &ended.stdout[..]), (Some(1), ""), "{ended:?}");
        assert_eq!(ended.stderr.lines().count(), 1, "{ended:?}");
    }
}

#[test]
fn json_contains_every_figure() {
    let home = Home::new();
    home.write("a.txt", MAZE);
    home.write("closed.txt", CLOSED);
    let ended = home.run(&["fast-run", "a.txt", "closed.txt", "--route", "all", "--json"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(1), ""));
    let json = ended.json();
    let keys = |value: &Value| value.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    assert_eq!(json.as_array().unwrap().len(), 6);
    assert_eq!((&json[0]["route"], &json[2]["route"]), (&json!("fastest"), &json!("fewest-turns")));
    assert_eq!(json[0]["moves"], "N 0 l90R@1400 2");
    assert_eq!(json[0]["cells"], json!([[0, 0], [0, 1], [1, 1], [2, 1]]));
    assert_eq!(json[0]["slalom_turns_by_kind"], json!({ "l90": 1 }));
    assert_eq!((&json[0]["error"], &json[0]["loss_percent"]), (&Value::Null, &json!(0.0)));
    assert_eq!(json[3]["error"], "goal unreachable: the start at (0, 0) has walls on all sides");
    assert_eq!(keys(&json[3]), ["error", "maze", "path", "route", "vehicle"]);
    assert_eq!(json[0].get("segments"), None);

    let run = home.run(&["fast-run", "winding river", "--json", "--explain"]).json()[0].clone();
    let segments = run["segments"].as_array().unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let (mut time, mut length, mut speed) = (0.0, 0.0, 0.0);
    for segment in segments {
        let acceleration = &segment["centripetal_acceleration_mm_s2"];
        assert_eq!(acceleration.is_null(), !segment["steps"].is_null());
        // The turns of the vehicle need at most 2.54 g.
        assert!(acceleration.as_f64().is_none_or(|mm_s2| (10_000.0..25_000.0).contains(&mm_s2)));
        assert!((number(&segment["entry_speed_mm_s"]) - speed).abs() < 1e-6);
        speed = number(&segment["exit_speed_mm_s"]);
        assert!(number(&segment["top_speed_mm_s"]) >= speed - 1e-6);
        time += number(&segment["duration_s"]);
        length += number(&segment["length_mm"]);
        assert!((number(&segment["end_s"]) - time).abs() < 1e-9);
    }
    assert!(speed.abs() < 1e-6, "the run ends at rest");
    assert!((number(&run["time_s"]) - time).abs() < 1e-9);
    assert!((number(&run["length_mm"]) - length).abs() < 1e-6);
    let turns = segments.iter().filter(|segment| segment["steps"].is_null()).count();
    assert_eq!((&json!(turns), 2 * turns + 1), (&run["slalom_turns"], segments.len()));
}

/// The walls of a recorded search, with all unknown walls closed, can only lengthen the run.
#[test]
fn a_recording_stands_for_the_walls_that_its_mouse_knows() {
    let home = Home::new();
    let demo = ["demo", "harbour", "--once", "--port", "0", "--record", "runs"];
    assert_eq!(home.run(&demo).code, Some(0));
    let file = recorded(&home.path().join("runs"));
    let file = file.to_str().unwrap();
    let ended = home.run(&["fast-run", file, "harbour", "--json"]);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let (known, all) = (&ended.json()[0], &ended.json()[1]);
    assert_eq!(known["path"], file);
    assert!(known["time_s"].as_f64() > all["time_s"].as_f64(), "{known}");
    let state = home.run(&["replay", file, "--json"]).json()["state"].clone();
    let visited = |cell: &Value| {
        let [x, y] = [0, 1].map(|at| usize::try_from(cell[at].as_u64().unwrap()).unwrap());
        state["walls"][x][y].as_u64().unwrap() & 1 == 1
    };
    assert!(known["cells"].as_array().unwrap().iter().all(visited), "{known}");
    let csv = home.run(&["fast-run", file, "--csv", "-", "--interval", "1000"]);
    assert!(csv.code == Some(0) && csv.stdout.starts_with("time_s,"), "{csv:?}");

    let whole = fs::read(file).unwrap();
    home.write("cut.mcap", &whole[..whole.len() / 2]);
    let ended = home.run(&["fast-run", "cut.mcap"]);
    assert!(ended.code == Some(1) && ended.stderr.contains("cut.mcap"), "damaged: {ended:?}");
    home.write("cut.mcap", &whole[..200]);
    let ended = home.run(&["fast-run", "cut.mcap", "harbour", "--json"]);
    assert!(ended.code == Some(1) && ended.stderr.starts_with("mmsim: cut.mcap: "), "{ended:?}");
    assert_eq!(ended.json().as_array().unwrap().len(), 1, "the other maze is read");
}

#[test]
fn every_size_of_maze_has_a_time() {
    let home = Home::new();
    let time = |arguments: &[&str]| {
        let ended = home.run(&[&["fast-run", "--json"], arguments].concat());
        assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""), "{arguments:?}");
        ended.json()[0]["time_s"].as_f64().unwrap()
    };
    // 45 + 14 · 180 + 45 mm: up to 2.5 m/s at 17 m/s², on at this speed, and down.
    home.write("corridor.txt", corridor(15));
    let expected = 2.0 * 2.5 / 17.0 + (2.61 - 2.5 * 2.5 / 17.0) / 2.5;
    assert!((time(&["corridor.txt"]) - expected).abs() < 1e-9);
    home.write("here.txt", "o---o---o\n|SG     |\no---o---o\n");
    for route in ["fastest", "fewest-cells", "fewest-turns"] {
        assert!(time(&["here.txt", "--route", route]).abs() < 1e-12);
    }
    let ended = home.run(&["fast-run", "here.txt", "--explain"]);
    insta::assert_snapshot!(ended.stdout, @r"
    here.txt: fastest run of expert
    time      0.000 s from rest to rest, 0.000 s from gate to gate
    distance  0.000 m, 0 cells
    speed     mean 0.000 m/s, top 0.000 m/s
    turns     none
    run       N 0
    ");
    let generate = ["mazes", "generate", "--size", "32x32", "--seed", "1", "-o", "large.txt"];
    assert_eq!(home.run(&generate).code, Some(0));
    let times = ["ukmars", "ares", "expert", "kerise"]
        .map(|vehicle| time(&["large.txt", "--vehicle", vehicle]));
    assert!(times[0] > times[1] && times[1] > times[2], "{times:?}");
}

#[test]
fn csv_follows_the_motion_of_the_mouse() {
    let home = Home::new();
    let run = home.run(&["fast-run", "galleries", "--json"]).json()[0].clone();
    let number = |key: &str| run[key].as_f64().unwrap();
    let read = |text: &str| -> Vec<[f64; 7]> {
        let mut lines = text.lines();
        let head = "time_s,x_mm,y_mm,heading_rad,speed_mm_s,acceleration_mm_s2,\
                    angular_velocity_rad_s";
        assert_eq!(lines.next(), Some(head));
        let row = |line: &str| -> Vec<f64> {
            line.split(',').map(|field| field.parse().unwrap()).collect()
        };
        lines.map(|line| row(line).try_into().unwrap()).collect()
    };
    let ended = home.run(&["fast-run", "galleries", "--csv", "run.csv"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    assert!(ended.stdout.starts_with("04-galleries.txt: fastest run of expert\n"));
    let rows = read(&fs::read_to_string(home.path().join("run.csv")).unwrap());
    let time = number("time_s");
    // All lines but the last one are at regular times.
    let check_times = |rows: &[[f64; 7]], interval: f64| {
        let (last, regular) = rows.split_last().unwrap();
        for (index, row) in (0_u32..).zip(regular) {
            assert!((row[0] - f64::from(index) * interval).abs() < 1e-6, "{row:?}");
        }
        assert!((last[0] - time).abs() < 1e-6, "{last:?}");
        assert!(time - regular[regular.len() - 1][0] < interval + 1e-6, "{last:?}");
    };
    check_times(&rows, 0.001);
    let mut length = 0.0;
    for pair in rows.windows(2) {
        let [t, x, y, heading, v, _, turning] = pair[1];
        let [before, x_before, y_before, heading_before, v_before, a_before, turning_before] =
            pair[0];
        let elapsed = t - before;
        assert!(elapsed > 0.0 && elapsed < 0.001_001, "{pair:?}");
        let (east, north) = (x - x_before, y - y_before);
        let distance = east.hypot(north);
        length += distance;
        // Within 1 ms, the speed changes by at most 17 mm/s. The coordinates have three decimals.
        assert!((distance - f64::midpoint(v, v_before) * elapsed).abs() < 0.02, "{pair:?}");
        assert!((v - v_before).abs() < 17.1, "{pair:?}");
        assert!(a_before.abs() < 17_000.1);
        let turned = f64::midpoint(turning, turning_before) * elapsed;
        assert!((heading - heading_before - turned).abs() < 0.001, "{pair:?}");
        // The mouse moves where it heads. It turns by at most 0.03 rad within 1 ms.
        let aside = north * heading.cos() - east * heading.sin();
        assert!(aside.abs() < 0.03 * distance + 0.002, "{pair:?}");
    }
    assert!((length - number("length_mm")).abs() < 0.001 * length);
    let start = rows[0];
    assert_eq!((start[0], start[1], start[4]), (0.0, 90.0, 0.0));
    let last = rows[rows.len() - 1];
    let cells = run["cells"].as_array().unwrap();
    let goal = &cells[cells.len() - 1];
    for (axis, value) in [(0, last[1]), (1, last[2])] {
        let within = value / 180.0 - goal[axis].as_f64().unwrap();
        assert!((0.0..1.0).contains(&within), "{last:?} is not in {goal}");
    }

    let ended = home.run(&["fast-run", "galleries", "--csv", "-", "--interval", "250"]);
    check_times(&read(&ended.stdout), 0.25);
    home.write("here.txt", "o---o\n|SG |\no---o\n");
    let rows = read(&home.run(&["fast-run", "here.txt", "--csv", "-"]).stdout);
    assert_eq!(rows, [[0.0, 90.0, 90.0, rows[0][3], 0.0, 0.0, 0.0]]);
}

#[test]
fn a_vehicle_file_starts_from_a_preset() {
    let home = Home::new();
    home.write("a.txt", MAZE);
    let printed = home.run(&["fast-run", "--print-vehicle", "--vehicle", "ares"]);
    assert_eq!((printed.code, &printed.stderr[..]), (Some(0), ""));
    insta::assert_snapshot!(printed.stdout, @r#"
    # Lengths in mm, times in s, speeds in mm/s, accelerations in mm/s².
    name = "ares"
    cell = 180
    start_offset = 45
    stop_offset = 45
    search_speed = 500
    search_turn_time = 0.25

    [along]
    acceleration = 10000
    braking = 10000
    top_speed = 5000

    [diagonal]
    acceleration = 10000
    braking = 10000
    top_speed = 5000

    [turns] # with their centripetal accelerations
    s90 = { length = 116, speed = 500 }            # 0.52 g
    l90 = { length = 195, speed = 909 }            # 1.02 g
    180 = { speed = 886 }                          # 1.02 g
    45in = { length = 100, speed = 850 }           # 0.87 g
    135in = { length = 230, speed = 800 }          # 1.00 g
    45out = { length = 100, speed = 850 }          # 0.87 g
    135out = { length = 220, speed = 650 }         # 0.69 g
    v90 = { length = 125, speed = 600 }            # 0.69 g
    "#);
    let time = |vehicle: &str| {
        let json = home.run(&["fast-run", "a.txt", "--json", "--vehicle", vehicle]).json();
        (json[0]["vehicle"].as_str().unwrap().to_string(), json[0]["time_s"].as_f64().unwrap())
    };
    home.write("same.toml", &printed.stdout);
    assert_eq!(time("same.toml"), time("ares"));
    home.write("my mouse.toml", "base = 'ares'\nalong.acceleration = 12_000\n");
    let (name, faster) = time("my mouse.toml");
    assert_eq!(name, "my mouse");
    assert!(faster < time("ares").1);
}

#[test]
fn wrong_vehicle_files_name_the_file_the_line_and_the_range() {
    let home = Home::new();
    home.write("a.txt", MAZE);
    let error = |content: &str| {
        home.write("v.toml", content);
        let ended = home.run(&["fast-run", "a.txt", "--vehicle", "v.toml"]);
        assert_eq!((ended.code, &ended.stdout[..]), (Some(2), ""), "{ended:?}");
        let (error, _) = ended.stderr.split_once("\n\n").unwrap();
        error.to_string()
    };
    insta::assert_snapshot!(error("base = 'expert'\n[turns]\nl90.length = 400"), @"error: invalid value 'v.toml' for '--vehicle <NAME|FILE>': line 3: turn l90 does not fit: its arc of 400 mm is 102.5 mm too long (at most 297.4 mm)");
    insta::assert_snapshot!(error("base = 'expert'\n\nalong.acceleration = -17000"), @"error: invalid value 'v.toml' for '--vehicle <NAME|FILE>': line 3: along.acceleration: expected 100 to 100000 mm/s², found -17000 mm/s²");
    insta::assert_snapshot!(error("base = 'expert'\nalong.top_speed = 2.5"), @"error: invalid value 'v.toml' for '--vehicle <NAME|FILE>': line 2: along.top_speed: expected 50 to 20000 mm/s, found 2.5 mm/s (if it is in m/s, write 2500)");
    insta::assert_snapshot!(error("base = 'expert'\ncell = 0.18"), @"error: invalid value 'v.toml' for '--vehicle <NAME|FILE>': line 2: cell: expected 10 to 1000 mm, found 0.18 mm (if it is in m, write 180)");
    insta::assert_snapshot!(error("base = 'expert'\nturns.l90.lenght = 200"), @"error: invalid value 'v.toml' for '--vehicle <NAME|FILE>': line 2: unknown field `lenght`, expected `length` or `speed`");
    insta::assert_snapshot!(error("base = expert"), @"error: invalid value 'v.toml' for '--vehicle <NAME|FILE>': line 1: expected a number, false, or a text in quotes");
}

#[test]
fn doubtful_vehicles_are_driven_with_a_warning() {
    let home = Home::new();
    home.write("a.txt", MAZE);
    home.write("fast.toml", "base = 'expert'\nturns.l90.speed = 2500");
    home.write("straight.toml", "base = 'expert'\n[turns]\n45in = false\n135in = false");
    let vehicles = ["fast.toml", "straight.toml", "fast.toml", "ares"];
    let vehicles = vehicles.map(|name| ["--vehicle", name]).concat();
    let ended = home.run(&[&["fast-run", "a.txt"], &vehicles[..]].concat());
    assert_eq!((ended.code, ended.stdout.lines().count()), (Some(0), 4));
    insta::assert_snapshot!(ended.stderr, @r"
    mmsim: warning: fast: turn l90 at 2500 mm/s on an arc of 267 mm needs 5.6 g of centripetal acceleration (at 3 g: 1825 mm/s)
    mmsim: warning: straight: no turn leads onto diagonals, so the mouse does not drive them (add 45in or 135in)
    ");
    let compare = ["compare", "a.txt", "--strategies", "flood-fill", "--vehicle", "fast.toml"];
    for arguments in [&compare[..], &["contest", "a.txt", "--vehicle", "fast.toml"]] {
        let ended = home.run(arguments);
        assert_eq!(ended.code, Some(0), "{ended:?}");
        assert_eq!(ended.stderr.matches("warning: fast: turn l90").count(), 1, "{ended:?}");
    }
    home.write("none.toml", "base = 'expert'\ndiagonal = false");
    let ended = home.run(&["fast-run", "--vehicle", "none.toml", "--print-vehicle"]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    assert!(!ended.stdout.contains("[diagonal]") && !ended.stdout.contains("45in"), "{ended:?}");
}

#[test]
fn usage_errors_set_exit_code_2() {
    let home = Home::new();
    home.write("a.txt", MAZE);
    home.write("b.txt", MAZE);
    home.write("other.toml", "base = 'ares'\nname = 'expert'");
    for (arguments, error) in [
        (&["a.txt", "--vehicle", "exprt"][..], "(did you mean expert?)"),
        (&["a.txt", "--vehicle", "none.toml"], "cannot read the file: "),
        (
            &["a.txt", "--vehicle", "expert", "--vehicle", "other.toml"],
            "expert and other.toml are both called",
        ),
        (&["a.txt", "-o", "a.svg", "--width", "300"], "--width needs a .png or .gif file"),
        (&["a.txt", "--route", "short"], "[possible values: fastest"),
        (&["a.txt", "b.txt", "--csv", "-"], "--csv takes one maze, found 2"),
        (&["a.txt", "--c-array", "-", "--route", "all"], "--c-array takes one route, found 3"),
        (&["a.txt", "--csv", "-", "--vehicle", "ares", "--vehicle", "expert"], "one vehicle"),
        (&["a.txt", "--csv", "-", "--json"], "can print to stdout"),
        (&["a.txt", "--csv", "-", "--c-array", "-"], "can print to stdout"),
        (&["a.txt", "--csv", "-", "--interval", "0"], "milliseconds from 0.1 to 1000"),
        (&["a.txt", "--interval", "5"], "--csv"),
        (&["a.txt", "--print-vehicle"], "cannot be used with"),
        (
            &["--print-vehicle", "--vehicle", "ares", "--vehicle", "expert"],
            "--print-vehicle takes one vehicle, found 2",
        ),
    ] {
        let ended = home.run(&[&["fast-run"], arguments].concat());
        assert_eq!((ended.code, &ended.stdout[..]), (Some(2), ""), "{arguments:?}: {ended:?}");
        assert!(ended.stderr.contains(error), "{arguments:?}: {}", ended.stderr);
    }
    let ended = home.run(&["fast-run", "a.txt", "--csv", "none/run.csv"]);
    assert_eq!((ended.code, &ended.stdout[..]), (Some(1), ""));
    assert!(ended.stderr.starts_with("mmsim: cannot write none/run.csv: "), "{}", ended.stderr);
}
