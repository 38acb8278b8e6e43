//! Checks the channels of JSON messages in recordings as other tools read them: with the official
//! MCAP library and with the schemas in the file.

use std::collections::BTreeMap;
use std::fs;
use std::ops::ControlFlow;
use std::path::Path;

use boon::{Compiler, Schemas};
use mmsim_client::{InMemory, search_run};
use mmsim_maze::{KnownMaze, Maze, Pose};
use mmsim_recording::{NewMessages, Recording, RecordingWriter};
use mmsim_run::messages;
use mmsim_server::Simulation;
use mmsim_solvers::{BundledStrategy, Mouse, PathBounds};
use serde_json::{Value, json};

/// What a mouse itself knows in each state.
struct Observed {
    pose: Pose,
    steps: u32,
    turns: u32,
    visited: usize,
    bounds: PathBounds,
}

/// The messages of each topic, with their sequences and times.
type Topics = BTreeMap<String, Vec<(u32, u64, Value)>>;

/// Records a search as a server would.
fn record(path: &Path, maze: &Maze, strategy: BundledStrategy, has_json: bool) -> Vec<Observed> {
    let mut simulation = Simulation::new("maze", maze.clone());
    let info = simulation.info();
    let messages: NewMessages = messages;
    let writer = RecordingWriter::create(path, &info, Some(maze)).unwrap();
    let mut writer = writer.with_messages(has_json.then_some(messages));
    let mut transport = InMemory::new(|request, reply| {
        simulation.handle(request, reply);
        if request.starts_with(b"S") {
            writer.write_with_update(simulation.history().newest_update(), request).unwrap();
        }
    });
    let mut mouse = Mouse::new(strategy.strategy(), KnownMaze::unexplored(maze), maze.start());
    let mut observed = Vec::new();
    search_run(&mut transport, &mut mouse, strategy.max_states(), |mouse, run| {
        observed.push(Observed {
            pose: mouse.pose(),
            steps: run.stats.steps(),
            turns: run.stats.turns(),
            visited: mouse.map().visited().len(),
            bounds: PathBounds::new(mouse.map()),
        });
        ControlFlow::Continue(())
    })
    .unwrap();
    writer.close().unwrap();
    observed
}

/// Reads all JSON messages with the official MCAP library. Checks the encodings, and each message
/// against the schema in the file.
fn read(path: &Path) -> Topics {
    let bytes = fs::read(path).unwrap();
    let mut topics = Topics::new();
    let (mut schemas, mut indexes) = (Schemas::new(), BTreeMap::new());
    for message in mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap) {
        let channel = &message.channel;
        if channel.message_encoding != "json" {
            continue;
        }
        let schema = channel.schema.as_ref().unwrap();
        assert_eq!(schema.encoding, "jsonschema");
        let index = *indexes.entry(channel.topic.clone()).or_insert_with(|| {
            let schema: Value = serde_json::from_slice(&schema.data).unwrap();
            let (mut compiler, url) = (Compiler::new(), format!("mem:{}", channel.topic));
            compiler.add_resource(&url, schema).unwrap();
            compiler.compile(&url, &mut schemas).unwrap()
        });
        let value: Value = serde_json::from_slice(&message.data).unwrap();
        if let Err(error) = schemas.validate(&value, index) {
            panic!("{}: {value}: {error}", channel.topic);
        }
        assert_eq!(message.log_time, message.publish_time);
        let messages = topics.entry(channel.topic.clone()).or_default();
        messages.push((message.sequence, message.log_time, value));
    }
    topics
}

#[test]
fn each_state_has_a_message_with_the_figures_of_the_mouse() {
    for (maze, strategy) in [
        (mmsim_mazes::HARBOUR, BundledStrategy::FloodFill),
        (mmsim_mazes::HEDGEROW, BundledStrategy::Swing),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        let maze = maze.parse().unwrap();
        let observed = record(&path, &maze, strategy, true);
        let (recording, topics) = (Recording::open(&path).unwrap(), read(&path));
        let mouse = &topics["/mouse"];
        assert_eq!((mouse.len(), recording.history().len()), (observed.len(), observed.len()));
        for (index, (observed, (sequence, time, message))) in observed.iter().zip(mouse).enumerate()
        {
            assert_eq!((*sequence as usize, Some(*time)), (index, recording.times().get(index)));
            let Pose { cell, heading } = observed.pose;
            let key = |key: &str| message[key].clone();
            assert_eq!([key("x"), key("y")], [json!(cell.x), json!(cell.y)]);
            assert_eq!(key("heading"), heading.letter().to_string());
            let degrees = 90 * "NESW".find(heading.letter()).unwrap();
            assert_eq!(key("heading_degrees"), degrees);
            assert_eq!(
                [key("steps"), key("turns")],
                [observed.steps, observed.turns].map(Value::from),
                "state {index}"
            );
            assert_eq!(key("visited_cells"), observed.visited);
            let PathBounds { optimistic, pessimistic } = observed.bounds;
            assert_eq!(message.get("optimistic_distance"), optimistic.map(Value::from).as_ref());
            assert_eq!(message.get("pessimistic_distance"), pessimistic.map(Value::from).as_ref());
        }
        let mut phases: Vec<_> =
            mouse.iter().map(|(_, _, it)| it["phase"].as_str().unwrap()).collect();
        phases.dedup();
        let expected: &[_] = match strategy {
            BundledStrategy::FloodFill => &["search_run", "at_goal"],
            _ => &["search_run", "at_goal", "return_run", "at_start", "fast_run", "at_goal"],
        };
        assert_eq!(phases, expected);
    }
}

/// Without a path, the distances are absent.
#[test]
fn an_unreachable_goal_has_no_distance() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let maze: Maze = "o---o---o\n| S | G |\no---o---o\n".parse().unwrap();
    let info = Simulation::new("small", maze.clone()).info();
    let writer = RecordingWriter::create(&path, &info, Some(&maze)).unwrap();
    let mut writer = writer.with_messages(Some(messages));
    for _ in 0..10 {
        writer.write(b"S\x00\x00NC\x01\x00C\x1f\x00").unwrap();
    }
    writer.close().unwrap();
    let (_, _, message) = &read(&path)["/mouse"][9];
    let expected = json!({
        "x": 0, "y": 0, "heading": "N", "heading_degrees": 0, "phase": "search_run",
        "phase_number": 0, "steps": 0, "turns": 0, "visited_cells": 1,
    });
    assert_eq!(*message, expected);
}

/// Foxglove and Lichtblick draw the maze and the mouse.
#[test]
fn the_maze_and_the_mouse_can_be_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let (path, maze) = (folder.path().join("a.mcap"), mmsim_mazes::HARBOUR.parse().unwrap());
    let observed = record(&path, &maze, BundledStrategy::FloodFill, true);
    let topics = read(&path);
    let [(0, _, scene)] = &topics["/scene"][..] else { panic!("one message") };
    let entity = &scene["entities"][0];
    let has = |value: &Value, keys: &[&str]| {
        assert!(keys.iter().all(|key| value.get(key).is_some()), "{value}: {keys:?}");
    };
    has(scene, &["deletions", "entities"]);
    has(entity, &["timestamp", "frame_id", "id", "lifetime", "frame_locked", "metadata"]);
    has(
        entity,
        &["arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models"],
    );
    let line = &entity["lines"][0];
    has(
        line,
        &["type", "pose", "thickness", "scale_invariant", "points", "color", "colors", "indices"],
    );
    let points = line["points"].as_array().unwrap();
    let length: f64 = points
        .chunks(2)
        .map(|ends| {
            let side = |key: &str| ends[1][key].as_f64().unwrap() - ends[0][key].as_f64().unwrap();
            side("x") + side("y")
        })
        .sum();
    let size = maze.size();
    let inner = size.cells().flat_map(|cell| {
        [mmsim_maze::Heading::South, mmsim_maze::Heading::West].map(|side| (cell, side))
    });
    let inner = inner.filter(|&(cell, side)| maze.walls().has(cell, side)).count();
    let walls = inner + usize::from(size.width()) + usize::from(size.height());
    let walls = f64::from(u32::try_from(walls).unwrap());
    assert!((length - walls).abs() < 1e-9, "{length} cells of walls, expected {walls}");
    assert_eq!(entity["cubes"].as_array().unwrap().len(), maze.goals().len());
    let poses = &topics["/pose"];
    assert_eq!(poses.len(), observed.len());
    for ((_, time, message), Observed { pose: Pose { cell, heading }, .. }) in
        poses.iter().zip(observed)
    {
        let stamp = &message["timestamp"];
        assert_eq!(
            stamp["sec"].as_u64().unwrap() * 1_000_000_000 + stamp["nsec"].as_u64().unwrap(),
            *time
        );
        let (position, turn) = (&message["pose"]["position"], &message["pose"]["orientation"]);
        assert_eq!(*position, json!({"x": f64::from(cell.x), "y": f64::from(cell.y), "z": 0.}));
        let (z, w) = (turn["z"].as_f64().unwrap(), turn["w"].as_f64().unwrap());
        let degrees = (2. * z.atan2(w)).to_degrees().rem_euclid(360.);
        let expected = [90., 0., 270., 180.]["NESW".find(heading.letter()).unwrap()];
        assert!((degrees - expected).abs() < 1e-9, "{heading:?}: {degrees}");
    }
}

/// Foxglove and Lichtblick reject a channel if a property has several types.
#[test]
fn viewers_accept_the_schema() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    record(&path, &mmsim_mazes::HARBOUR.parse().unwrap(), BundledStrategy::FloodFill, true);
    let bytes = fs::read(&path).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let schemas: BTreeMap<&str, Value> = summary
        .schemas
        .values()
        .map(|schema| (&*schema.name, serde_json::from_slice(&schema.data).unwrap()))
        .collect();
    let names: Vec<&str> = schemas.keys().copied().collect();
    assert_eq!(names, ["foxglove.PoseInFrame", "foxglove.SceneUpdate", "mmsim.Mouse"]);
    schemas.values().for_each(check_object);
    let mouse = &schemas["mmsim.Mouse"];
    assert_eq!(mouse["additionalProperties"], false);
    let properties = mouse["properties"].as_object().unwrap();
    for (name, property) in properties {
        assert!(property["title"].is_string() && property["description"].is_string(), "{name}");
    }
    let titles = properties["phase_number"]["oneOf"].as_array().unwrap();
    let titles: Vec<&Value> = titles.iter().map(|phase| &phase["title"]).collect();
    assert!(titles.into_iter().eq(properties["phase"]["enum"].as_array().unwrap()));
}

fn check_object(schema: &Value) {
    assert_eq!(schema["type"], "object", "{schema}");
    for (name, property) in schema["properties"].as_object().unwrap() {
        match (property["type"].as_str(), property["oneOf"].as_array()) {
            (Some("string" | "integer" | "number" | "boolean"), None) => {}
            (Some("object"), None) => check_object(property),
            (Some("array"), None) => check_object(&property["items"]),
            (None, Some(all)) => assert!(all.iter().all(|one| one["const"].is_u64()), "{name}"),
            _ => panic!("{name}: {property}"),
        }
    }
}

#[test]
fn a_recording_without_json_contains_only_states() {
    let folder = tempfile::tempdir().unwrap();
    let maze = mmsim_mazes::HARBOUR.parse().unwrap();
    let [with, without] = [true, false].map(|has_json| {
        let path = folder.path().join(format!("{has_json}.mcap"));
        record(&path, &maze, BundledStrategy::FloodFill, has_json);
        (Recording::open(&path).unwrap(), read(&path), fs::metadata(&path).unwrap().len())
    });
    assert!(without.1.is_empty());
    assert!(with.0.history().iter().eq(without.0.history().iter()));
    for index in 0..with.0.history().len() {
        assert_eq!(with.0.history().context(index), without.0.history().context(index));
    }
    let states = with.0.history().len();
    println!("{states} states in {} bytes, without JSON in {}", with.2, without.2);
    assert!(with.2 > without.2);
}
