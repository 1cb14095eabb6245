"""What is asked: the table of parameters, YAML, the scenario and what may be made of one."""

from .scenario import (
    Loop as Loop,
)
from .scenario import (
    Scenario as Scenario,
)
from .scenario import (
    block_spec as block_spec,
)
from .scenario import (
    config_directory as config_directory,
)
from .scenario import (
    find as find,
)
from .scenario import (
    load as load,
)
from .scenario import (
    monitor_defaults as monitor_defaults,
)
from .scenario import (
    parse as parse,
)
from .scenario import (
    shipped as shipped,
)
