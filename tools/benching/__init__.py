"""How fast usdfoot is: kernels, set-up of steps, and the whole way on disk.

To be imported before numpy, so that one core does the work whatever numpy is built with.
"""

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"
