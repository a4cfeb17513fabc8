"""What studies put out: Markdown tables, CSV and figures. Files are whole or not there."""
import contextlib
import csv
import os
import statistics
import sys
import tempfile


def median(values):
    return statistics.median(list(values))


def rms(values):
    return statistics.mean(value**2 for value in values) ** 0.5


def ms(seconds, digits=1):
    return f"{1e3 * seconds:.{digits}f}"


def print_row(*cells):
    print("| " + " | ".join(map(str, cells)) + " |", flush=True)


def print_head(*columns):
    print_row(*columns)
    print("|---" * len(columns) + "|", flush=True)


def print_table(columns, rows):
    print_head(*columns)
    for row in rows:
        print_row(*row)


@contextlib.contextmanager
def whole_file(path):
    """The name of a file beside `path`, which it becomes at the end. Ends the program when it cannot be written."""
    try:
        handle, beside = tempfile.mkstemp(suffix=os.path.splitext(path)[1], dir=os.path.dirname(os.path.abspath(path)))
        os.close(handle)
        try:
            yield beside
            os.chmod(beside, 0o644)
            os.replace(beside, path)
        except BaseException:
            os.unlink(beside)
            raise
    except OSError as error:
        sys.exit(f"ringsplat: {path} cannot be written: {error}")


def read_csv(path):
    try:
        with open(path, newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))
    except OSError as error:
        sys.exit(f"ringsplat: {path} cannot be read: {error}")


def write_csv(path, rows, columns=None):
    with whole_file(path) as beside, open(beside, "w", newline="", encoding="utf-8") as file:
        out = csv.DictWriter(file, columns or list(rows[0]), lineterminator="\n")
        out.writeheader()
        out.writerows(rows)


def plotting():
    """matplotlib without a display, in one style; not imported where nothing is drawn."""
    try:
        import matplotlib
    except ImportError:
        sys.exit("ringsplat: plots need matplotlib: apt-get install python3-matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    plt.rcParams.update({"figure.facecolor": "white", "grid.color": "0.9", "axes.axisbelow": True, "legend.fontsize": 8})
    return plt


def write_figure(figure, path):
    with whole_file(path) as beside:
        figure.savefig(beside, dpi=130)
    print(path, file=sys.stderr)
