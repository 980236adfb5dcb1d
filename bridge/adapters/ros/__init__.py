"""ROS 2 without ROS: a robot of the link as a node, in the wire format of rmw_zenoh.

`wire` is that format, `messages` converts the contract's messages and recordings, `bridge` is the node.
"""
