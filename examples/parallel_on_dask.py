"""A batch on several processes: any executor of concurrent.futures, such as that of a Dask cluster."""

try:
    from distributed import Client, LocalCluster
except ImportError:
    raise SystemExit("This example needs distributed: python -m pip install distributed") from None

import warnings

import numpy as np

import jtik

if __name__ == "__main__":  # each worker imports this file
    ur5e = jtik.Robot.builtin("ur5e")
    ik = jtik.InverseKinematics(ur5e, jtik.FrameTask("tip", kind="pose"))
    goals = [ur5e.pose(ur5e.random_configuration(seed)) for seed in range(200)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Dask warns about ports and sockets
        with (
            LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
            Client(cluster) as client,
        ):
            batch = ik.solve_batch(goals, restarts=20, executor=client.get_executor(), block=50)
    print(batch)
    np.testing.assert_array_equal(batch.q, ik.solve_batch(goals, restarts=20).q)
