"""A HyperQueue server with two workers of one core each, until it is killed: `cluster.py DIRECTORY`, which must not exist."""

import signal
import sys

from hyperqueue import LocalCluster
from hyperqueue.cluster import WorkerConfig

cluster = LocalCluster(sys.argv[1], WorkerConfig(cores=1))
cluster.start_worker(WorkerConfig(cores=1))
print("ready", flush=True)
signal.pause()
