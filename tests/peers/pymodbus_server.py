"""Serving a pymodbus context: the part of pymodbus that differs between its versions 3.0 (Debian 12)
and 3.8 (Debian 13).

Each function starts a server and returns what to await to go on serving.
"""
import asyncio

import pymodbus

IS_3_0 = pymodbus.__version__.startswith("3.0.")
if IS_3_0:
    from pymodbus.server.async_io import ModbusSerialServer, ModbusTcpServer
else:
    from pymodbus.server import ModbusSerialServer, ModbusTcpServer


async def serve_tcp(context):
    """On a free port of loopback; the port comes first."""
    server = ModbusTcpServer(context, address=("127.0.0.1", 0))
    if IS_3_0:
        serving = asyncio.create_task(server.serve_forever())
        await server.serving  # until it listens
        return server.server.sockets[0].getsockname()[1], serving
    await server.serve_forever(background=True)
    return server.transport.sockets[0].getsockname()[1], server.serving


async def serve_serial(context, port):
    """On a serial port, with RTU frames."""
    server = ModbusSerialServer(context, port=port, baudrate=115200)
    if IS_3_0:
        await server.start()
        return asyncio.create_task(server.serve_forever())
    await server.serve_forever(background=True)
    return server.serving
