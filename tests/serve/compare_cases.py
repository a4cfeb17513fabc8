"""Two volumes from one view: `serve A B`, and two of a series."""
import os, subprocess

from server_case import expect


def make_two(options):
    """Two of the same name in two folders and one on another grid. Returns the first."""
    for name, shape, dims in (("a/density", "shell", "24x20x28"), ("b/density", "ball", "24x20x28"), ("other", "ball", "8x8x8")):
        path = os.path.join(options.scratch, f"{name}.nrrd")
        os.makedirs(os.path.dirname(path), exist_ok=True)
        subprocess.run([options.program, "synth", shape, "-o", path, "--dims", dims], check=True, capture_output=True)
    return os.path.join(options.scratch, "a", "density.nrrd")


def two_volumes(options, server):
    """Volumes that are named one by one are a series, those of the same name by their paths; all on one grid."""
    client = server.client()
    same = [os.path.join(options.scratch, folder, "density.nrrd") for folder in "ab"]
    expect(client.hello["frames"] == same, client.hello["frames"])
    first, second = [client.picture(seq=client.view(frame=frame), at_rest=1) for frame in (0, 1)]
    expect(first.file != second.file, "the same picture twice")
    client.close()
    # What cannot be shown is refused at once, not when somebody looks at it.
    for more, words in ((["--frames", "all"], "--frames"), ([same[1][:-1]], f"cannot open {same[1][:-1]}: No such file"),
                        (["step_*.nrrd"], "step_*.nrrd is no file, but a pattern for several"),
                        ([os.path.join(options.scratch, "other.nrrd")], "must lie on one grid")):
        refused = subprocess.run([options.program, "serve", *same, *more], capture_output=True, text=True, timeout=60)
        expect(refused.returncode == 2 and words in refused.stderr, refused.stderr)
