"""What *starts*, watches and stops a graph of nodes.

May import: `forest_ident`, `forest_control`, `forest_sim`, `forest_bag`, `forest_msgs_py`,
`forest_description`.
"""
