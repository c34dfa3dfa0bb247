"""The e-puck2's Wi-Fi protocol: packets, a simulated robot that answers, a driver of what speaks it.

`packets` is the format on the wire, `units` what its counts mean, `device` the simulated robot without a
socket, `server` its socket. On the other side `channel` brings packets, over TCP or from a `device` behind a
`model` of a real link, and `driver` makes a `Robot` and its `World` of them.
"""
