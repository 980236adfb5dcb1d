"""ROS 2 without ROS: a robot of the link as a node, in the wire format of rmw_zenoh.

`wire` is that format, `messages` turns the contract's messages into ROS messages (recordings too), `bridge` is
the node.
"""
