"""A REP server of libzmq that sends every request back. The argument is its port."""

import sys

import zmq

socket = zmq.Context().socket(zmq.REP)
socket.bind(f"tcp://127.0.0.1:{sys.argv[1]}")
while True:
    socket.send_multipart(socket.recv_multipart())
