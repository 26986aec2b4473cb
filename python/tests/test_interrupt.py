"""Ctrl-C while the module works."""

import signal
import subprocess
import sys
import threading
import time

import pytest

# What work takes minutes if it is not interrupted; the room can be used afterwards.
SCRIPT = """
import signal, sys, threading
import raywalk

# Where SIGINT is ignored, as in background jobs, Python leaves it so.
signal.signal(signal.SIGINT, signal.default_int_handler)

room = raywalk.Room(sys.argv[1])
work = {
    "path": lambda: [None for _ in room.path([[0.1, 0.2]] * 5000, width_px=1024)],
    "write_path": lambda: room.write_path(sys.argv[3], sys.argv[4], width_px=1024),
}[sys.argv[2]]

def on_a_thread():
    try:
        work()
    except KeyboardInterrupt:
        print("stopped", flush=True)

print("begin", flush=True)
try:
    if len(sys.argv) > 5:
        thread = threading.Thread(target=on_a_thread)
        thread.start()
        thread.join()
    else:
        work()
except KeyboardInterrupt as e:
    print("interrupted:", e, flush=True)
    if len(sys.argv) > 5:
        thread.join()
print(room.view(0.0, 0.0, width_px=64).shape, flush=True)
work()
"""


@pytest.mark.parametrize("work", ["path", "write_path", "thread"])
def test_sigint_stops_work_and_raises_keyboard_interrupt(room_folder, tmp_path, work):
    table = tmp_path / "walk.csv"
    table.write_text("name,x,z\n" + "".join(f"v{i},0.1,0.2\n" for i in range(2000)))
    arguments = [room_folder, "path" if work == "thread" else work, table, tmp_path / "out"]
    process = subprocess.Popen(
        [sys.executable, "-c", SCRIPT, *arguments, *(["thread"] if work == "thread" else [])],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    watchdog = threading.Timer(30.0, process.kill)
    watchdog.start()
    assert process.stdout.readline() == "begin\n"
    first = tmp_path / "out" / "v0.png"
    for _ in range(500 if work == "write_path" else 20):
        if first.exists():
            break
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    # The thread stops and the room is used again in either order.
    expected = ["(32,", "interrupted:"] + (["stopped"] if work == "thread" else [])
    lines = sorted(process.stdout.readline().rstrip() for _ in expected)
    assert [line.split()[0] for line in lines] == expected
    if work == "write_path":
        assert "of 2000 views; the same command resumes" in lines[1]
        assert first.exists()
    time.sleep(0.2)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate()
    watchdog.cancel()
    assert process.returncode == -signal.SIGINT
    assert errors.rstrip().splitlines()[-1].startswith("KeyboardInterrupt")
