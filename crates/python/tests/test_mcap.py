"""Recordings that the official MCAP library has written."""
from itertools import product
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

import micromouse_sim as mm

STATES = 192


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording with many updates."""
    path = tmp_path_factory.mktemp("mcap") / "run.mcap"
    simulator = mm.Simulator(mm.Maze.bundled("01"))
    simulator.name("Theseus")
    for number in range(STATES):
        simulator.walls(number % 16, 0, "N")
        simulator.text(0, 0, str(number))
        simulator.state(number % 16, 0, "N", [[number % 256] * 16] * 16, simulator.unexplored())
    simulator.save(path)
    return path


def copy(recorded: Path, path: Path, is_description_last: bool, video: bytes, **options: Any) -> None:
    """Writes a recording anew, with the messages and the attachment of another program."""
    with recorded.open("rb") as source, path.open("wb") as target:
        reader, writer = make_reader(source), Writer(target, **options)
        metadata = list(reader.iter_metadata())

        def describe() -> None:
            for record in metadata:
                writer.add_metadata(record.name, record.metadata)

        writer.start()
        video_channel = writer.register_channel("/video", "raw", 0)
        if not is_description_last:
            describe()
        channels: dict[int, int] = {}
        for _, channel, message in reader.iter_messages(log_time_order=False):
            if channel.id not in channels:
                channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, 0)
            writer.add_message(channels[channel.id], message.log_time, message.data,
                               message.publish_time, message.sequence)
            if channel.topic == "/state":
                writer.add_message(video_channel, message.log_time, video, message.publish_time)
        writer.add_attachment(0, 0, "video.mp4", "video/mp4", bytes(20 << 20))
        if is_description_last:
            describe()
        writer.finish()  # type: ignore[no-untyped-call]


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize(
    "chunks", [{"use_chunking": False}, {"chunk_size": 1}, {"chunk_size": 4096}, {"chunk_size": 1 << 30}]
)
def test_recordings_of_the_official_library_are_read(
    recorded: Path, tmp_path: Path, compression: CompressionType, chunks: dict[str, Any]
) -> None:
    expected, path = mm.load_recording(recorded), tmp_path / "copy.mcap"
    # The largest chunk has 18 MB.
    for is_description_last, video in product([False, True], [b"", bytes(100_000)]):
        copy(recorded, path, is_description_last, video, compression=compression, **chunks)
        found = mm.load_recording(path)
        assert found.is_complete and found.maze == expected.maze and found.info == expected.info
        assert len(found.states) == STATES and list(found.states) == list(expected.states)
