"""The nodes of a GLB file, and which of them are a skeleton (glTF 2.0, sections 3.5.2, 3.7.3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from mgjax.core import quaternion
from mgjax.core.skeleton import MAX_DEPTH
from mgjax.io.gltf.document import Document


@dataclass(frozen=True, kw_only=True)
class Node:
    """A node as the file has it.

    Attributes:
        name: not necessarily unique, or empty.
        parent: index of the node above, or −1.
        children: indices of those below.
        translation, rotation, scale: local; the rotation is wxyz, unit.
        bare: neither mesh nor camera nor anything else hangs on it.
        is_end: said to mark only the end of a bone.
    """

    name: str
    parent: int
    children: tuple[int, ...]
    translation: Float[np.ndarray, "3"]
    rotation: Float[np.ndarray, "4"]
    scale: Float[np.ndarray, "3"]
    bare: bool
    is_end: bool


def read_nodes(document: Document) -> list[Node]:
    """All nodes; :class:`FileFormatError` unless they are trees."""
    items = document.objects(document.json, "nodes")
    children = [tuple(document.indices(item, "children", len(items))) for item in items]
    parents = [-1] * len(items)
    for above, below in enumerate(children):
        for node in below:
            if parents[node] >= 0 or node == above:
                document.refuse(f"node {node} below two nodes", "a tree of nodes")
            parents[node] = above
    nodes: list[Node] = []
    for index, item in enumerate(items):
        translation, rotation, scale = _transform(document, item, index)
        nodes.append(
            Node(
                name=document.text(item, "name", ""),
                parent=parents[index],
                children=children[index],
                translation=translation,
                rotation=rotation,
                scale=scale,
                bare=not {"mesh", "camera", "extensions"} & set(item),
                is_end=_said_to_be_end(item),
            )
        )
    for index in range(len(nodes)):
        ancestors(document, nodes, index)
    return nodes


def _said_to_be_end(item: dict[str, Any]) -> bool:
    extras = item.get("extras")
    return isinstance(extras, dict) and extras.get("end_joint") is True


def ancestors(document: Document, nodes: list[Node], node: int) -> list[int]:
    """The nodes above one, from the topmost down, itself last."""
    chain = [node]
    while (parent := nodes[chain[-1]].parent) >= 0:
        chain.append(parent)
        if len(chain) > MAX_DEPTH:
            document.refuse(f"node {node} more than {MAX_DEPTH} deep", "a tree of nodes")
    return chain[::-1]


def _transform(
    document: Document, item: dict[str, Any], index: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    matrix = document.numbers(item, "matrix", 16)
    if matrix is not None:
        return _decompose(document, np.array(matrix).reshape(4, 4).T, index)
    translation = np.array(document.numbers(item, "translation", 3) or [0.0, 0.0, 0.0])
    xyzw = np.array(document.numbers(item, "rotation", 4) or [0.0, 0.0, 0.0, 1.0])
    scale = np.array(document.numbers(item, "scale", 3) or [1.0, 1.0, 1.0])
    length = float(np.linalg.norm(xyzw))
    if not 0.5 < length < 2:
        document.refuse(f"a rotation of length {length:g} of node {index}", "a unit quaternion")
    if abs(length - 1) > 1e-6:
        xyzw = xyzw / length
    return translation, xyzw[[3, 0, 1, 2]], scale


def _decompose(
    document: Document, matrix: np.ndarray, index: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A matrix as translation, rotation and scale; it must have no shear, as the format asks."""
    linear = matrix[:3, :3]
    scale = np.linalg.norm(linear, axis=0)
    if np.linalg.det(linear) < 0:
        scale[0] = -scale[0]
    if (np.abs(scale) < 1e-12).any():
        document.refuse(f"a matrix of node {index} that flattens", "one that can be inverted")
    turn = linear / scale
    if not np.allclose(turn.T @ turn, np.eye(3), atol=1e-3):
        document.refuse(f"a matrix of node {index} with shear", "rotation and scale only")
    return matrix[:3, 3], np.asarray(quaternion.from_matrix(turn)), scale


def skeleton_nodes(document: Document, nodes: list[Node], animated: set[int]) -> list[int]:
    """The nodes that make the skeleton, a parent before its children, the root first.

    Where there are skins, they are those of the largest skin and what hangs on its root: bones of
    other skins (hair, clothes), and nodes without a mesh, which mark ends. Without a skin they are
    the animated nodes and all below them. Parts that hang on other nodes than most of the skeleton
    does (targets of inverse kinematics, props) are left out.
    """
    skins = document.objects(document.json, "skins")
    joints = [set(document.indices(skin, "joints", len(nodes))) for skin in skins]
    members = max(joints, key=len, default=set())
    bones = set().union(*joints) if members else animated
    if not bones:
        document.refuse("neither a skin nor an animation of nodes", "an animated skeleton")
    root = _root(document, nodes, members or animated)
    while nodes[root].parent in bones:
        root = nodes[root].parent
    wanted = _wanted(nodes, root, bones | animated, everything=not members)
    return _in_order(document, nodes, root, wanted, skins)


def _root(document: Document, nodes: list[Node], members: set[int]) -> int:
    """The lowest of the members that has most of them at or below it."""
    below: dict[int, int] = {}
    for member in members:
        for node in ancestors(document, nodes, member):
            below[node] = below.get(node, 0) + 1
    inside = [node for node in sorted(members) if nodes[node].parent not in members]
    return max(inside, key=lambda node: below[node])


def _wanted(nodes: list[Node], root: int, bones: set[int], *, everything: bool) -> set[int]:
    """Nodes below the root (itself included) that are bones, lead to bones, or are bare leaves."""
    order = [root]
    for node in order:
        order += nodes[node].children
    wanted: set[int] = {root}
    for node in reversed(order):
        leaf = nodes[node].bare and not nodes[node].children
        leads = any(child in wanted for child in nodes[node].children)
        if everything or node in bones or leads or leaf:
            wanted.add(node)
    return wanted


def _in_order(
    document: Document,
    nodes: list[Node],
    root: int,
    wanted: set[int],
    skins: list[dict[str, Any]],
) -> list[int]:
    """The order of a skin that lists all of them, parents first, or else depth first."""
    for skin in skins:
        listed = document.indices(skin, "joints", len(nodes))
        rank = {node: i for i, node in enumerate(listed)}
        if set(listed) == wanted and all(
            node == root or rank[nodes[node].parent] < rank[node] for node in listed
        ):
            return listed
    order: list[int] = []
    stack = [root]
    while stack:
        node = stack.pop()
        order.append(node)
        stack += [child for child in reversed(nodes[node].children) if child in wanted]
    return order


def unique_names(nodes: list[Node], order: list[int]) -> tuple[str, ...]:
    """Their names; nameless ones are called after their number, doubles get a number."""
    taken: set[str] = set()
    names: list[str] = []
    for index in order:
        base = nodes[index].name or f"node_{index}"
        name, number = base, 1
        while name in taken:
            number += 1
            name = f"{base}_{number}"
        taken.add(name)
        names.append(name)
    return tuple(names)
