#!/usr/bin/python3
"""The far side of the virtual machine's serial ports: drives, cables, and hands that act on orders.

  serial_host.py --serial SOCKET --usb SOCKET --orders SOCKET

SOCKETs are QEMU's: of a serial port and of a USB adapter with a drive (pymodbus_slave.py) behind
each, and of the port that orders come from. An order is a line, answered by "done NUMBER" or
"failed WHY":

  LINE corrupt N    of every N replies one has a bit flipped
  LINE truncate N   ... ends early
  LINE lose N       ... does not come
  LINE double N     ... comes twice
  LINE noise N      ... comes after other bytes
  LINE delay N      ... comes late, when the master has given it up
  LINE cut          no byte passes any more
  LINE heal         the line is sound; NUMBER of replies that were spoilt
  LINE stops        NUMBER of stop commands the master has sent so far
  LINE kill, start  the drive loses power, and comes back without its home
  LINE unplug, plug, replug    the adapter; replug takes a second

LINE is "serial" or "usb". Ends when QEMU closes the port of the orders.
"""
import argparse
import os
import pathlib
import select
import signal
import socket
import subprocess
import sys
import time
import tty

SLAVE = pathlib.Path(__file__).parents[1] / "peers" / "pymodbus_slave.py"
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
    def __init__(self):
        # The interpreter for which Debian's pymodbus is installed.
        self.process = subprocess.Popen(
            ["/usr/bin/python3", str(SLAVE), "--map", "generic", "--line", "pty"],
            stdout=subprocess.PIPE, text=True)
        ready, _, port = self.process.stdout.readline().strip().partition(" ")
        if ready != "ready":
            raise RuntimeError("the pymodbus slave does not start")
        self.fd = os.open(port, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.fd)

    def end(self):
        self.process.kill()
        self.process.wait()
        os.close(self.fd)


class Line:
    """The link between a port of the virtual machine and a drive."""

    def __init__(self, path):
        self.path = path
        self.port = None
        self.drive = Drive()
        self.fault, self.every = None, 1
        self.replies = self.spoilt = 0
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
        self.spoilt += 1
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

    def obey(self, deed, argument):
        if deed in ("corrupt", "truncate", "lose", "double", "noise", "delay", "cut"):
            self.fault, self.every, self.spoilt = deed, int(argument or 1), 0
        elif deed == "heal":
            self.fault = None
            return self.spoilt
        elif deed == "stops":
            return self.requests.count(STOP)
        elif deed == "kill":
            self.drive.end()
            self.drive = None
        elif deed == "start":
            self.drive = Drive()
        elif deed == "plug":
            self.port = connected(self.path)
        elif deed == "unplug":
            self.unplug()
        elif deed == "replug":
            self.unplug()
            time.sleep(1)
            self.port = connected(self.path)
        else:
            raise ValueError("no such order")
        return 0

    def unplug(self):
        self.port.close()
        self.port = None


def answer_to(order, lines):
    try:
        name, deed, *arguments = order.split()
        return "done %d" % lines[name].obey(deed, *(arguments or [None]))
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
    for name in ("serial", "usb", "orders"):
        parser.add_argument("--" + name, required=True)
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # terminates the drives, too
    lines = {"serial": Line(options.serial), "usb": Line(options.usb)}
    try:
        lines["serial"].obey("plug", None)
        serve(connected(options.orders), lines)
    finally:
        for line in lines.values():
            if line.drive:
                line.drive.end()


if __name__ == "__main__":
    sys.exit(main())
