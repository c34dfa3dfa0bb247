"""The commands about robots behind a link: a server that is one, and what measures one."""
