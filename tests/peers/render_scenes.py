"""Renders scenes with Mitsuba 3 (variant `scalar_rgb`) for tests/peers/mitsuba.rs.

Takes the number of threads as its argument. Each line of the input is a number of runs and, after a
space, a scene file. The answer is a line `ok WIDTH HEIGHT SAMPLES CHANNEL...`, followed by the pictures of
the runs as little-endian f32, pixel by pixel; or a line `error MESSAGE`.
"""

import sys

import drjit
import mitsuba
import numpy

mitsuba.set_variant("scalar_rgb")
mitsuba.set_log_level(mitsuba.LogLevel.Error)
drjit.set_thread_count(int(sys.argv[1]))


def render(path, runs):
    scene = mitsuba.load_file(path)
    sensor = scene.sensors()[0]
    pictures = []
    for seed in range(runs):
        mitsuba.render(scene, seed=seed)
        # What the film holds, since the tensor that `render` returns does not name its channels.
        pictures.append(sensor.film().bitmap())
    names = [field.name for field in pictures[0].struct_()]
    width, height = pictures[0].size()
    samples = sensor.sampler().sample_count()
    header = " ".join(map(str, ["ok", width, height, samples, *names]))
    return header, [numpy.array(picture, dtype="<f4") for picture in pictures]


for line in sys.stdin:
    runs, path = line.rstrip("\n").split(" ", 1)
    try:
        header, pictures = render(path, int(runs))
    except Exception as error:
        header, pictures = "error " + " ".join(str(error).split()), []
    sys.stdout.buffer.write(header.encode() + b"\n")
    for picture in pictures:
        sys.stdout.buffer.write(picture.tobytes())
    sys.stdout.buffer.flush()
