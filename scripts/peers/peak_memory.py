"""Runs a program and notes the largest memory of its processes, in bytes:  peak_memory.py PREFIX PROGRAM...

Writes PREFIX.PID, so that every rank has a file of its own; ends as the program does.
"""
import os
import resource
import subprocess
import sys

ended = subprocess.run(sys.argv[2:]).returncode
with open(f"{sys.argv[1]}.{os.getpid()}", "w", encoding="utf-8") as file:
    print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024, file=file)
sys.exit(ended if ended >= 0 else 128 - ended)
