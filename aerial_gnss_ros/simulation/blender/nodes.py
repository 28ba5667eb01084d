# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Materials and sky as Blender node trees."""

from __future__ import annotations

from typing import Any

import numpy as np

from aerial_gnss_ros.core.geometry.refraction import WATER_INDEX
from aerial_gnss_ros.simulation.blender.shot import Shot

COLOURS = "colour"
"""Attribute of faces with their reflectance."""
FOAM = "foam"


def rgba(colour: Any, gain: float = 1.0) -> tuple[float, float, float, float]:
    """Blue, green, red as Blender's red, green, blue, alpha."""
    b, g, r = (float(c) * gain for c in colour)
    return r, g, b, 1.0


def _tree(name: str) -> tuple[Any, Any, Any]:
    import bpy

    material = bpy.data.materials.new(name)
    tree = material.node_tree
    tree.nodes.clear()
    return material, tree, tree.nodes.new("ShaderNodeOutputMaterial")


def _node(tree: Any, kind: str, /, **inputs: Any) -> Any:
    node = tree.nodes.new(f"ShaderNode{kind}")
    for name, value in inputs.items():
        socket = node.inputs[name.replace("_", " ")]
        if hasattr(value, "is_linked"):
            tree.links.new(value, socket)
        else:
            socket.default_value = value
    return node


def painted(roughness: float, metallic: float = 0.0, wear: float = 0.2) -> Any:
    """Paint whose colour is the mesh's face attribute, a little uneven."""
    material, tree, output = _tree("painted")
    colour = tree.nodes.new("ShaderNodeAttribute")
    colour.attribute_name = COLOURS
    place = tree.nodes.new("ShaderNodeTexCoord")
    dirt = _node(tree, "TexNoise", Vector=place.outputs["Object"], Scale=9.0, Detail=4.0)
    range_ = _node(tree, "MapRange", Value=dirt.outputs["Factor"])
    range_.inputs["From Min"].default_value, range_.inputs["From Max"].default_value = 0.3, 0.7
    range_.inputs["To Min"].default_value, range_.inputs["To Max"].default_value = 1.0 - wear, 1.0
    worn = tree.nodes.new("ShaderNodeVectorMath")
    worn.operation = "SCALE"
    tree.links.new(colour.outputs["Color"], worn.inputs[0])
    tree.links.new(range_.outputs["Result"], worn.inputs["Scale"])
    surface = _node(tree, "BsdfPrincipled", Roughness=roughness, Metallic=metallic)
    tree.links.new(worn.outputs["Vector"], surface.inputs["Base Color"])
    tree.links.new(surface.outputs[0], output.inputs["Surface"])
    return material


def glowing(level: tuple[float, float, float]) -> Any:
    """A uniform glow (red, green, blue), for pictures of masks."""
    material, tree, output = _tree("glowing")
    glow = _node(tree, "Emission", Color=(*level, 1.0), Strength=1.0)
    tree.links.new(glow.outputs[0], output.inputs["Surface"])
    return material


def window_pane() -> Any:
    """Water that only refracts: for pictures of masks."""
    material, tree, output = _tree("pane")
    bend = _node(tree, "BsdfRefraction", Roughness=0.0, IOR=WATER_INDEX)
    tree.links.new(bend.outputs[0], output.inputs["Surface"])
    return material


def water(shot: Shot, foam: bool) -> tuple[Any, Any]:
    """Waves over absorbing and scattering water: one material for reflections, one for the rest.

    The images of the two materials add up. A single material would choose reflection or refraction
    at random for each path (one in thirty), and be very noisy.

    The water is not a scattering volume either, which would be noisy. It emits uniformly as in
    daylight, E / sigma being the radiance of deep water and sigma its attenuation, which Cycles
    integrates without noise: L = L_deep (1 - exp(-sigma d)) + L_object exp(-sigma d).

    Args:
        shot: colours and wind.
        foam: whether the mesh has the attribute `FOAM`.
    """
    return _mirror(shot, foam), _body(shot, foam)


def _waves(tree: Any, shot: Shot) -> tuple[Any, Any, Any]:
    """Place, normal of ripples too short for the mesh, and Fresnel's reflectance."""
    place = tree.nodes.new("ShaderNodeTexCoord")
    ripples = _node(
        tree, "TexNoise", Vector=place.outputs["Object"], Scale=14.0, Detail=3.0, Roughness=0.6
    )
    bump = _node(tree, "Bump", Height=ripples.outputs["Factor"], Strength=1.0)
    bump.inputs["Distance"].default_value = 0.0006 * (1.0 + shot.scene.wind_speed)
    fresnel = _node(tree, "Fresnel", IOR=WATER_INDEX, Normal=bump.outputs[0])
    return place, bump.outputs[0], fresnel.outputs[0]


def _mirror(shot: Shot, foam: bool) -> Any:
    material, tree, output = _tree("mirror")
    place, normal, fresnel = _waves(tree, shot)
    # Widening of highlights by slopes of waves too short for mesh and ripples (Cox and Munk 1954).
    slope = float(np.sqrt(0.35 * (0.003 + 0.00512 * shot.scene.wind_speed)))
    shine = _node(tree, "BsdfAnisotropic", Roughness=0.75 * float(np.sqrt(slope)), Normal=normal)
    tree.links.new(fresnel, shine.inputs["Color"])
    wet = shine.outputs[0]
    if foam:
        wet = _mix(tree, _foam_share(tree, place), wet, _foam(tree, 0.0))
    tree.links.new(_for_light(tree, wet), output.inputs["Surface"])
    return material


def _body(shot: Shot, foam: bool) -> Any:
    material, tree, output = _tree("body")
    place, normal, fresnel = _waves(tree, shot)
    passed = tree.nodes.new("ShaderNodeMath")
    passed.operation = "SUBTRACT"
    passed.inputs[0].default_value = 1.0
    tree.links.new(fresnel, passed.inputs[1])
    bend = _node(tree, "BsdfRefraction", Roughness=0.05, IOR=WATER_INDEX, Normal=normal)
    tree.links.new(passed.outputs[0], bend.inputs["Color"])
    wet = bend.outputs[0]
    if foam:
        wet = _mix(tree, _foam_share(tree, place), wet, _foam(tree, 1.0))
    tree.links.new(_for_light(tree, wet), output.inputs["Surface"])
    sigma = np.array(shot.scene.attenuation)
    glow = np.array(shot.scene.water_colour) * sigma * shot.sea.scatter * daylight(shot)
    # Blender absorbs density (1 - colour).
    absorb = _node(tree, "VolumeAbsorption", Density=float(sigma.max()))
    absorb.inputs["Color"].default_value = rgba(1.0 - sigma / sigma.max())
    shine = _node(tree, "Emission", Color=rgba(glow / glow.max()), Strength=float(glow.max()))
    both = tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(absorb.outputs[0], both.inputs[0])
    tree.links.new(shine.outputs[0], both.inputs[1])
    tree.links.new(both.outputs[0], output.inputs["Volume"])
    return material


def _for_light(tree: Any, wet: Any) -> Any:
    """Lets light from above reach objects under water, on a straight path."""
    path = tree.nodes.new("ShaderNodeLightPath")
    clear = tree.nodes.new("ShaderNodeBsdfTransparent")
    return _mix(tree, path.outputs["Is Shadow Ray"], wet, clear.outputs[0])


def _mix(tree: Any, share: Any, first: Any, second: Any) -> Any:
    node = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(share, node.inputs[0])
    tree.links.new(first, node.inputs[1])
    tree.links.new(second, node.inputs[2])
    return node.outputs[0]


def _foam(tree: Any, gain: float) -> Any:
    return _node(tree, "BsdfDiffuse", Color=rgba((0.78, 0.77, 0.75), gain)).outputs[0]


def _foam_share(tree: Any, place: Any) -> Any:
    """Foam of the modifier, torn by noise."""
    layer = tree.nodes.new("ShaderNodeAttribute")
    layer.attribute_name = FOAM
    holes = _node(tree, "TexNoise", Vector=place.outputs["Object"], Scale=6.0, Detail=5.0)
    product = tree.nodes.new("ShaderNodeMath")
    product.operation = "MULTIPLY"
    tree.links.new(layer.outputs["Factor"], product.inputs[0])
    torn = _node(tree, "MapRange", Value=holes.outputs["Factor"])
    torn.inputs["From Min"].default_value, torn.inputs["From Max"].default_value = 0.42, 0.62
    tree.links.new(torn.outputs["Result"], product.inputs[1])
    return product.outputs[0]


def daylight(shot: Shot) -> float:
    """Radiance of a white sheet on the ground, in the units of `sky`.

    For a clear sky a fit to what Blender 5.0 renders from 10 to 80 degrees of sun elevation, to
    about a tenth; which suffices for the exposure and the water's glow.
    """
    if shot.scene.sun_light <= 0.0:
        return 0.95
    up = np.sin(shot.scene.sun_elevation)
    direct = 46.0 * up**1.3 * shot.scene.sun_light
    return float(direct + 5.0 * up**0.45 * shot.sea.aerosol**0.2)


def sky(shot: Shot) -> None:
    """Makes the world: Blender's sky model with its sun, broken clouds, or a grey dome."""
    import bpy

    world = bpy.data.worlds.new("sky")
    bpy.context.scene.world = world
    tree = world.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputWorld")
    if shot.scene.sun_light <= 0.0:
        light = _grey(tree)
    else:
        light = _clear(tree, shot)
        if shot.sea.clouds:
            light = _clouded(tree, light, shot)
    background = _node(tree, "Background", Color=light, Strength=1.0)
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    world.cycles.sampling_method = "MANUAL"
    world.cycles.sample_map_resolution = 256


def _clear(tree: Any, shot: Shot) -> Any:
    node = tree.nodes.new("ShaderNodeTexSky")
    node.sky_type = "MULTIPLE_SCATTERING"
    node.sun_disc = True
    node.sun_elevation = shot.scene.sun_elevation
    node.sun_rotation = np.pi / 2 - shot.scene.sun_yaw  # clockwise from north (+y)
    node.sun_intensity = shot.scene.sun_light
    node.aerosol_density = shot.sea.aerosol
    node.ozone_density = shot.sea.ozone
    return node.outputs[0]


def _grey(tree: Any) -> Any:
    """An overcast sky, three times as bright overhead as at the horizon (Moon and Spencer)."""
    place = tree.nodes.new("ShaderNodeTexCoord")
    split = _node(tree, "SeparateXYZ", Vector=place.outputs["Generated"])
    level = _node(tree, "MapRange", Value=split.outputs["Z"])
    level.inputs["To Min"].default_value, level.inputs["To Max"].default_value = 0.4, 1.2
    return level.outputs["Result"]


def _clouded(tree: Any, light: Any, shot: Shot) -> Any:
    """Cumulus as noise on a plane overhead; its edges are soft."""
    place = tree.nodes.new("ShaderNodeTexCoord")
    noise = _node(tree, "TexNoise", Vector=place.outputs["Generated"], Scale=3.5, Detail=6.0)
    noise.noise_dimensions = "4D"
    noise.inputs["W"].default_value = float(shot.scene.seed % 1000)
    share = _node(tree, "MapRange", Value=noise.outputs["Factor"])
    share.inputs["From Min"].default_value, share.inputs["From Max"].default_value = 0.5, 0.62
    mixed = tree.nodes.new("ShaderNodeMix")
    mixed.data_type = "RGBA"
    tree.links.new(share.outputs["Result"], mixed.inputs["Factor"])
    tree.links.new(light, mixed.inputs[6])
    white = 0.6 * daylight(shot)
    mixed.inputs[7].default_value = (white, white, 1.03 * white, 1.0)
    return mixed.outputs[2]
