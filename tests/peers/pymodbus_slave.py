#!/usr/bin/python3
"""A slider's drive as a pymodbus slave: an independent peer for Raywalk's Modbus driver.

Written from the drives' published register layouts, independently of Raywalk's code and register
maps, to detect mistakes in either. Needs Debian's python3-pymodbus and python3-serial-asyncio.

  pymodbus_slave.py --map generic|leadshine-pr0 --line pty|tcp

Prints one line, "ready <device or TCP port>", and serves unit 1 until it is killed.
"""
import argparse
import asyncio
import math
import os
import threading
import time
import tty

from pymodbus.datastore import ModbusServerContext, ModbusSlaveContext
from pymodbus.datastore.store import BaseModbusDataBlock

from pymodbus_server import serve_serial, serve_tcp

HOME_OFFSET_MM = 37.0  # initial position of the carriage from the home switch


class Drive:
    """A single motion with a trapezoidal speed profile."""

    def __init__(self):
        self.start_mm = HOME_OFFSET_MM
        self.way_mm = 0.0
        self.began = time.monotonic()
        self.speed = self.acceleration = 1.0
        self.homing = False
        self.homed = False
        self.zero_mm = HOME_OFFSET_MM  # of the feedback

    def _times(self):
        way = abs(self.way_mm)
        peak = min(self.speed, math.sqrt(self.acceleration * way))
        ramp = peak / self.acceleration
        cruise = (way - peak * ramp) / peak if peak > 0 else 0.0
        return peak, ramp, max(cruise, 0.0)

    def position_mm(self):
        peak, ramp, cruise = self._times()
        t = time.monotonic() - self.began
        total = 2 * ramp + cruise
        way = abs(self.way_mm)
        if t >= total:
            gone = way
        elif t < ramp:
            gone = 0.5 * self.acceleration * t * t
        elif t < ramp + cruise:
            gone = peak * (t - 0.5 * ramp)
        else:
            gone = way - 0.5 * self.acceleration * (total - t) ** 2
        return self.start_mm + math.copysign(gone, self.way_mm)

    def moving(self):
        _, ramp, cruise = self._times()
        return time.monotonic() - self.began < 2 * ramp + cruise

    def feedback_mm(self):
        self._finish_homing()
        return self.position_mm() - self.zero_mm

    def _finish_homing(self):
        if self.homing and not self.moving():
            self.homing = False
            self.homed = True
            self.zero_mm = self.position_mm()

    def _begin(self, to_mm, speed, acceleration):
        here = self.position_mm()
        self.start_mm, self.way_mm = here, to_mm - here
        self.speed, self.acceleration = speed, acceleration
        self.began = time.monotonic()

    def move(self, target_mm, speed, acceleration):
        self._begin(self.zero_mm + target_mm, speed, acceleration)

    def home(self):
        self.homed, self.homing = False, True
        self._begin(0.0, 500.0, 5000.0)

    def stop(self):
        # Stops immediately; deceleration is not modelled.
        self.homing = False
        self._begin(self.position_mm(), 1.0, 1.0)


def signed(high, low):
    value = high << 16 | low
    return value - (1 << 32) if value >= 1 << 31 else value


def words(value):
    value &= 0xFFFFFFFF
    return value >> 16, value & 0xFFFF


class GenericRegisters:
    """The registers of configs/sliders/generic.yaml."""

    def __init__(self, drive):
        self.drive = drive
        self.held = {4: 0x5257}

    def read(self, address):
        high, low = words(round(self.drive.feedback_mm() * 100))
        moving = self.drive.moving()
        status = 1 << 1 | self.drive.homed << 2 | moving << 3 | (not moving) << 4
        return {0: status, 1: high, 2: low, 3: 0}.get(address, self.held.get(address, 0))

    def write(self, address, values):
        self.held.update((address + i, value) for i, value in enumerate(values))
        if address != 32:
            return
        if values[0] == 1:
            target = signed(self.held[16], self.held[17]) / 100
            self.drive.move(target, self.held[18] / 10, self.held[19])
        elif values[0] == 2:
            self.drive.home()
        elif values[0] == 3:
            self.drive.stop()


class LeadshineRegisters:
    """Path 0 of Leadshine's RS-485 drives with 10000 counts and 40 mm per turn."""

    def __init__(self, drive):
        self.drive = drive
        self.held = {}  # pymodbus answers a write with what it reads back, which has to be the same

    def read(self, address):
        high, low = words(round(self.drive.feedback_mm() * 250))
        moving = self.drive.moving()
        status = 1 << 1 | moving << 2 | (not moving) << 5 | self.drive.homed << 6
        return {0x1003: status, 0x1014: high, 0x1015: low}.get(address, self.held.get(address, 0))

    def write(self, address, values):
        self.held.update((address + i, value) for i, value in enumerate(values))
        if address == 0x6200 and values[0] == 1 and values[7] == 0x10:
            rpm, ms_to_1000_rpm = values[3], values[4]
            acceleration = 1000 / 60 * 40 / (ms_to_1000_rpm / 1000)
            self.drive.move(signed(values[1], values[2]) / 250, rpm / 60 * 40, acceleration)
        elif address == 0x6002 and values[0] == 0x20:
            self.drive.home()
        elif address == 0x6002 and values[0] == 0x40:
            self.drive.stop()


class Block(BaseModbusDataBlock):
    """All 65536 registers, computed when they are read.

    pymodbus counts a block's addresses from 1.
    """

    def __init__(self, registers):
        self.registers = registers

    def validate(self, address, count=1):
        return 1 <= address and address + count <= 0x10001

    def getValues(self, address, count=1):
        return [self.registers.read(address - 1 + i) for i in range(count)]

    def setValues(self, address, values):
        self.registers.write(address - 1, values if isinstance(values, list) else [values])

    def reset(self):
        pass


def pump(source, sink):
    while True:
        os.write(sink, os.read(source, 256))


def joined_terminals():
    """The slave ends of two pseudo-terminals whose master ends are connected."""
    (inner_a, outer_a), (inner_b, outer_b) = os.openpty(), os.openpty()
    for end in (outer_a, outer_b):
        tty.setraw(end)
    for source, sink in ((inner_a, inner_b), (inner_b, inner_a)):
        threading.Thread(target=pump, args=(source, sink), daemon=True).start()
    return os.ttyname(outer_a), os.ttyname(outer_b)


async def serve(options):
    registers = {"generic": GenericRegisters, "leadshine-pr0": LeadshineRegisters}[options.map]
    block = Block(registers(Drive()))
    unit = ModbusSlaveContext(hr=block, ir=block)
    context = ModbusServerContext(slaves={1: unit}, single=False)
    if options.line == "tcp":
        where, serving = await serve_tcp(context)
    else:
        inner, where = joined_terminals()
        serving = await serve_serial(context, inner)
    print("ready", where, flush=True)
    await serving


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--map", choices=["generic", "leadshine-pr0"], required=True)
    parser.add_argument("--line", choices=["pty", "tcp"], required=True)
    asyncio.run(serve(parser.parse_args()))


if __name__ == "__main__":
    main()
