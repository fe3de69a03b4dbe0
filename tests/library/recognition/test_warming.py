"""Machine code ahead of time."""

import json

PROGRAM = """
import json, os, sys, warnings
from pathlib import Path

os.environ["CONVEXPERC_CACHE_DIR"] = sys.argv[1]

warnings.simplefilter("error")
import numpy as np
from convexperc.features import lbp, FeatureConfiguration, extract
from convexperc.kernels.kernel import Kernel
from convexperc.recognition.warming import KERNELS, warm

assert "numba" not in sys.modules and "skimage.feature._hog" not in sys.modules
paths = warm()
made = [kernel._machine_code is not None for kernel in KERNELS]
known = [each for m in list(sys.modules.values()) for each in vars(m).values() if isinstance(each, Kernel)]
extract(np.zeros((2, 50, 50, 3), np.uint8), FeatureConfiguration())
print(json.dumps([made, len(paths), all(map(Path.is_file, paths)), {k.name for k in known} == {
    k.name for k in KERNELS}, [name for name in sys.modules if "skimage.feature._" in name]]))
"""


def test_every_kernel_is_made_and_kept(interpreter, tmp_path):
    """In a folder that no other process writes to while the files are counted."""
    done = interpreter.run(PROGRAM, tmp_path)
    assert done.returncode == 0, done
    made, count, kept, all_known, scikit_image = json.loads(done.stdout)
    assert all(made)
    assert count == len(made)
    assert kept
    assert all_known
    assert not scikit_image
