"""What the plotting scripts share: matplotlib without a display, and files that are whole or not there."""
import os
import sys
import tempfile

try:
    import matplotlib
except ImportError:
    sys.exit("this needs matplotlib: apt-get install python3-matplotlib, and the python3 it belongs to")

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402,F401


def write_figure(figure, path):
    """Beside its place first, so that a failure leaves no half file. Ends the program when it cannot be written."""
    try:
        handle, beside = tempfile.mkstemp(suffix=".png", dir=os.path.dirname(os.path.abspath(path)))
        os.close(handle)
        try:
            figure.savefig(beside, dpi=130)
            os.chmod(beside, 0o644)
            os.replace(beside, path)
        except BaseException:
            os.unlink(beside)
            raise
    except OSError as error:
        sys.exit(f"{path} cannot be written: {error}")
