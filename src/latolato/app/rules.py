"""Why work that a page asked for ends without a result; pages translate a rule by its name."""

from latolato.core.rules import Rule

RULES = {
    "large_for_memory": Rule("this file needs more memory than there is", "make it smaller"),
    "ended_by_itself": Rule(
        "the computation ended by itself: there was too little memory, or a file is broken"
    ),
}
