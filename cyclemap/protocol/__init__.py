"""A data collection as settings and files: from keys in degrees and millimetres to a loop and its
strategy, and back.

Loops
-----
loop_from_settings : from settings by name, as `--set` has them
loop_from_file : from a collection file, such as `cyclemap init` writes

Files
-----
read_protocol, write_protocol : settings and strategy as TOML
read_schedule, write_schedule : what the robot does, one row a cycle

An object of one's own
----------------------
read_outline, OutlineFile : its outline from a drawing or a model
check_collection, CheckedCollection : what is likely wrong with a collection file
"""

from typing import TYPE_CHECKING

from cyclemap.lazy_names import import_on_first_use

if TYPE_CHECKING:
    # What an editor and a type checker see; at run time each name is imported when it is first
    # used.
    from cyclemap.protocol.collection_file import loop_from_file as loop_from_file
    from cyclemap.protocol.outline_files import (
        OutlineFile as OutlineFile,
        read_outline as read_outline,
    )
    from cyclemap.protocol.own_object import (
        CheckedCollection as CheckedCollection,
        check_collection as check_collection,
    )
    from cyclemap.protocol.protocol_file import (
        read_protocol as read_protocol,
        write_protocol as write_protocol,
    )
    from cyclemap.protocol.schedule_file import (
        read_schedule as read_schedule,
        write_schedule as write_schedule,
    )
    from cyclemap.protocol.settings import loop_from_settings as loop_from_settings
else:
    import_on_first_use(__name__)
