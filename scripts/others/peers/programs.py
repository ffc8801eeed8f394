"""Runs of programs of their own."""

import resource
import subprocess
import time

import sheet


def cpu_of(command, limit):
    """Seconds that a command computed, and passed."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    try:
        subprocess.run(command, check=True, timeout=10 * limit + 10, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    except subprocess.TimeoutExpired:
        raise sheet.TooSlow(limit) from None
    except subprocess.CalledProcessError as error:
        lines = (error.stderr or error.stdout).strip().splitlines()
        raise sheet.Stopped(lines[0][:200] if lines else f"exit code {error.returncode}") from None
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, wall


def frames_alone(run):
    """Time of all frames of a program, without its start: run(frames) is (cpu, wall), and that of one frame is taken off."""
    cpu, wall = run(sheet.FRAMES)
    cpu_one, wall_one = run(1)
    part = sheet.FRAMES / (sheet.FRAMES - 1)
    return (cpu - cpu_one) * part, (wall - wall_one) * part
