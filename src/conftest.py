"""Lets pytest run the examples of any one file in ``latolato``.

Where a file is named alone, pytest imports the package around it, which imports the file, and then
runs the file once more: what it registers would be registered twice. Modules that are imported
before are taken as they are.
"""

import latolato.analysis
import latolato.observables
import latolato.physics.drives
import latolato.sweeps.executors  # noqa: F401
