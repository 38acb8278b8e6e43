"""Prints how long it takes to import the package, as the median over new interpreters."""
import statistics
import subprocess
import sys

ROUNDS = 15
PROGRAM = (
    "import time; start = time.perf_counter(); import micromouse_sim;"
    "print(time.perf_counter() - start)"
)


def import_time() -> float:
    """Returns the time of an import in a new interpreter, in seconds."""
    output = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, check=True).stdout
    return float(output)


if __name__ == "__main__":
    import_time()  # writes the byte code
    times = [import_time() for _ in range(ROUNDS)]
    print(f"import micromouse_sim: {1000 * statistics.median(times):.1f} ms (median of {ROUNDS})")
