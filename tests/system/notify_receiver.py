#!/usr/bin/env python3
"""Stands for a service manager: receives what a daemon notifies on a datagram socket and prints it, a line each.

notify_receiver.py SOCKET SERVED: next to READY=1 it says whether somebody listens on the unix socket SERVED then.
"""
import socket
import sys

receiver = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
receiver.bind(sys.argv[1])
while True:
    for line in receiver.recv(4096).decode().splitlines():
        if line == "READY=1":
            with socket.socket(socket.AF_UNIX) as probe:
                line += " open" if probe.connect_ex(sys.argv[2]) == 0 else " closed"
        print(line, flush=True)
