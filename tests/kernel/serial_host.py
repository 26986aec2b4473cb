#!/usr/bin/python3
"""The host side of the virtual machine's serial ports: drives, cables and fault injection.

  serial_host.py --drive PROGRAM --serial SOCKET --usb SOCKET --orders SOCKET

The SOCKETs are QEMU's: a serial port and a USB adapter, each connected to a drive (PROGRAM, which is
drive_on_terminal), and the port on which orders are received. An order is a text line, answered by
"done NUMBER" or "failed REASON":

  LINE corrupt N    flips a bit in one of every N replies
  LINE truncate N   ... truncates it
  LINE lose N       ... drops it
  LINE double N     ... sends it twice
  LINE noise N      ... sends other bytes before it
  LINE delay N      ... delays it beyond the master's timeout
  LINE cut          passes no bytes
  LINE heal         ends the fault; NUMBER is the count of faulty replies
  LINE stops        NUMBER is the count of stop commands sent by the master
  LINE kill, start  the drive loses power, and restarts without being homed
  LINE unplug, plug, replug    the adapter; replug takes a second

LINE is "serial" or "usb". Ends when QEMU closes the port of the orders.
"""
import argparse
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
import time
import tty

# Function 6, register 32, value 3: the stop command of configs/sliders/generic.yaml.
STOP = bytes.fromhex("010600200003")
# An emulated port delivers single bytes; a frame ends after a pause this long.
FRAME_GAP_S = 0.01
# Longer than the master's timeout of 0.3 s, and within the pause that it keeps afterwards.
LATE_S = 0.45


def connected(path):
    end = time.monotonic() + 60
    while True:
        line = socket.socket(socket.AF_UNIX)
        try:
            line.connect(path)
            return line
        except OSError:
            line.close()
            if time.monotonic() > end:
                raise
            time.sleep(0.05)


def frame_from(fd):
    """Reads all bytes up to a pause; empty if the other end has closed."""
    frame = b""
    while select.select([fd], [], [], FRAME_GAP_S if frame else 0)[0]:
        try:
            part = os.read(fd, 512)
        except OSError:
            part = b""
        if not part:
            return b""
        frame += part
    return frame


class Drive:
    def __init__(self, program):
        self.folder = tempfile.TemporaryDirectory()
        port = os.path.join(self.folder.name, "drive")
        self.process = subprocess.Popen([program, port], stdout=subprocess.PIPE, text=True)
        if self.process.stdout.readline().strip() != "ready":
            raise RuntimeError("the simulated drive does not start")
        self.fd = os.open(port, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.fd)

    def end(self):
        self.process.kill()
        self.process.wait()
        os.close(self.fd)
        self.folder.cleanup()


class Line:
    """The link between a port of the virtual machine and a drive."""

    def __init__(self, path, program):
        self.path = path
        self.program = program
        self.port = None
        self.drive = Drive(program)
        self.fault, self.every = None, 1
        self.replies = self.faulty = 0
        self.requests = bytearray()

    def sources(self):
        return [fd for fd in (self.port, self.drive and self.drive.fd) if fd is not None]

    def pass_on(self, source):
        if source is self.port:
            request = frame_from(self.port.fileno())
            self.requests += request
            if self.drive and self.fault != "cut":
                os.write(self.drive.fd, request)
        elif self.drive and source == self.drive.fd:
            for part in self.spoil(frame_from(source)):
                if self.port:
                    self.port.sendall(part)

    def spoil(self, reply):
        self.replies += 1
        if self.fault == "cut":
            return []
        if self.fault is None or self.replies % self.every:
            return [reply]
        self.faulty += 1
        if self.fault == "corrupt":
            middle = len(reply) // 2
            return [reply[:middle], bytes([reply[middle] ^ 0x10]), reply[middle + 1:]]
        if self.fault == "truncate":
            return [reply[:len(reply) // 2]]
        if self.fault == "double":
            return [reply, reply]
        if self.fault == "noise":
            return [b"\xff\x00\x55", reply]
        if self.fault == "delay":
            time.sleep(LATE_S)
            return [reply]
        return []  # lose

    def obey(self, order, argument):
        if order in ("corrupt", "truncate", "lose", "double", "noise", "delay", "cut"):
            self.fault, self.every, self.faulty = order, int(argument or 1), 0
        elif order == "heal":
            self.fault = None
            return self.faulty
        elif order == "stops":
            return self.requests.count(STOP)
        elif order == "kill":
            self.drive.end()
            self.drive = None
        elif order == "start":
            self.drive = Drive(self.program)
        elif order == "plug":
            self.port = connected(self.path)
        elif order == "unplug":
            self.unplug()
        elif order == "replug":
            self.unplug()
            time.sleep(1)
            self.port = connected(self.path)
        else:
            raise ValueError("unknown order")
        return 0

    def unplug(self):
        self.port.close()
        self.port = None


def answer_to(text, lines):
    try:
        name, order, *arguments = text.split()
        return "done %d" % lines[name].obey(order, *(arguments or [None]))
    except (KeyError, ValueError, OSError, RuntimeError) as error:
        return "failed %s" % error


def serve(orders, lines):
    pending = b""
    while True:
        sources = [orders] + [source for line in lines.values() for source in line.sources()]
        ready = select.select(sources, [], [])[0]
        for line in lines.values():
            for source in line.sources():
                if source in ready:
                    line.pass_on(source)
        if orders in ready:
            part = orders.recv(512)
            if not part:
                return
            pending += part
            while b"\n" in pending:
                order, _, pending = pending.partition(b"\n")
                answer = answer_to(order.decode(errors="replace"), lines)
                print("order:", order.decode(errors="replace"), "->", answer, flush=True)
                orders.sendall(answer.encode() + b"\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("drive", "serial", "usb", "orders"):
        parser.add_argument("--" + name, required=True)
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # terminates the drives, too
    lines = {name: Line(getattr(options, name), options.drive) for name in ("serial", "usb")}
    try:
        lines["serial"].obey("plug", None)
        serve(connected(options.orders), lines)
    finally:
        for line in lines.values():
            if line.drive:
                line.drive.end()


if __name__ == "__main__":
    sys.exit(main())
