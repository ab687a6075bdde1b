"""Decomposes a closed part with CoACD into convex pieces, more than needed; other code joins them again.

CoACD 1.0.14 makes the pieces, since it is better than miniacd 0.1.5 with its threshold 0.1. Measured on 44
parts: those of so101 and open_duck_mini whose hull is at least 10 % larger than they, simplified by
manifold3d 3.5.4, and their pieces joined:

| | CPU s in all | longest | failed | within the tolerance in 16 pieces | in 8 | extra volume in 16 |
| --- | --- | --- | --- | --- | --- | --- |
| CoACD, effort normal | 123 | 13 | 0 | 40 | 29 | 11 % |
| miniacd | 213 | 55 | 3 | 15 | 12 | 38 % |
"""

from linkwright.stages.mesh.configuration.decompose_options import CoacdParameters as CoacdParameters
from linkwright.stages.mesh.configuration.decompose_options import coacd_parameters as coacd_parameters
from linkwright.stages.mesh.decompose.coacd_pieces import NOT_CLOSED as NOT_CLOSED
from linkwright.stages.mesh.decompose.coacd_pieces import convex_pieces as convex_pieces
