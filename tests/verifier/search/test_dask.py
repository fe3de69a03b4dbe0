"""The search on a local Dask cluster, shown once: joblib's workers may be anywhere."""

import subprocess
import sys
from pathlib import Path

SCRIPT = """
import sys
sys.path.insert(0, {folder!r})
import joblib
from dask.distributed import Client, LocalCluster
from test_search import LARGE, SMALL, summary
from verification.search.engine import search

if __name__ == "__main__":
    alone = search([LARGE], SMALL, 3)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster):
        with joblib.parallel_config(backend="dask"):
            shared = search([LARGE], SMALL, 3, jobs=2)
    print(summary(alone) == summary(shared), alone.total, shared.total)
"""


def test_a_dask_cluster_finds_the_same(tmp_path: Path) -> None:
    file = tmp_path / "cluster.py"
    file.write_text(SCRIPT.format(folder=str(Path(__file__).parent)))
    done = subprocess.run(
        [sys.executable, str(file)], capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split()[-3:] == ["True", "60", "60"], (done.stdout, done.stderr)
