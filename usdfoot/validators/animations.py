"""Checks of written animations: complete, one entry a joint, unit rotations, contacts inside."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import Usd, UsdSkel

from usdfoot.analysis.array_faults import contact_faults, sign_changes, unlike_unit
from usdfoot.bridge.schema import applied_apis, has_api
from usdfoot.bridge.tokens import SIDES, Contact, Schema
from usdfoot.errors import SkeletonError
from usdfoot.maths.types import FloatArray
from usdfoot.readers.authored import authored
from usdfoot.readers.candidates import find_skeleton
from usdfoot.validators.findings import finding

__all__ = ["animation_of", "check_complete", "check_contacts", "check_joints", "check_rotations"]

PARTS = ("translations", "rotations", "scales")
"""Attributes of a SkelAnimation with one entry a joint."""


def check_complete(prim: Usd.Prim, time_range: Any) -> list[Any]:
    """Joints, translations, rotations and scales must be authored: a missing one silently gives the rest pose."""
    if not _is_ours(prim):
        return []
    missing = [name for name in ("joints", *PARTS) if not prim.GetAttribute(name).HasAuthoredValue()]
    remedy = f"author joints and, one entry a joint, {', '.join(PARTS)}"
    return [finding("MissingAttribute", prim, "is not authored", attribute=name, remedy=remedy) for name in missing]


def check_joints(prim: Usd.Prim, time_range: Any) -> list[Any]:
    """Joints must be unique and the Skeleton's, and every sample must have one entry for each."""
    if prim.IsA(UsdSkel.Root):
        return _check_skeleton(prim)
    joints = [str(joint) for joint in authored(prim, "joints") or ()]
    if not _is_ours(prim) or not joints:
        return []
    found = []
    if len(set(joints)) < len(joints):
        twice = sorted({joint for joint in joints if joints.count(joint) > 1})
        what = f"names {twice[0]} more than once"
        found.append(finding("DuplicateJoints", prim, what, attribute="joints", remedy="name every joint once"))
    for part in PARTS:
        attribute = prim.GetAttribute(part)
        for code in _samples_of(attribute, time_range):
            count = len(attribute.Get(code) or ())
            if count != len(joints):
                at = "" if code.IsDefault() else f" at time code {code.GetValue():g}"
                what = f"has {count} entries{at} for {len(joints)} joints"
                found.append(finding("JointArrayLength", prim, what, attribute=part, remedy="author one a joint"))
                break
    return found


def check_rotations(prim: Usd.Prim, time_range: Any) -> list[Any]:
    """Rotations must be unit quaternions, and of two samples that follow on the same side of the sphere."""
    attribute = prim.GetAttribute("rotations")
    if not _is_ours(prim) or not attribute:
        return []
    codes = _samples_of(attribute, time_range)
    joints = list(authored(prim, "joints") or ())
    kept = [(code, np.array(value)) for code in codes if len(value := attribute.Get(code) or ()) == len(joints) > 0]
    if not kept:
        return []
    rotations = np.stack([value for _, value in kept]).astype(float)
    found = []
    odd = np.argwhere(unlike_unit(rotations))
    if len(odd):
        frame, joint = odd[0]
        length = np.linalg.norm(rotations[frame, joint])
        what = f"of {joints[joint]}{_at(kept[frame][0])} has the length {length:.4g} ({len(odd)} such in all)"
        remedy = "author unit quaternions"
        found.append(finding("RotationNotUnit", prim, what, attribute="rotations", remedy=remedy))
    turned = np.argwhere(sign_changes(rotations))
    if len(turned):
        frame, joint = turned[0]
        what = f"of {joints[joint]} changes sign{_at(kept[frame + 1][0])} ({len(turned)} such in all)"
        remedy = "negate the quaternions from there on: the same rotations, without a jump between the samples"
        found.append(finding("RotationSignChange", prim, what, attribute="rotations", remedy=remedy))
    return found


def check_contacts(prim: Usd.Prim, time_range: Any) -> list[Any]:
    """Contacts must be in order and inside the animation."""
    found = []
    codes = prim.GetAttribute("rotations").GetTimeSamples() or prim.GetAttribute("translations").GetTimeSamples()
    for side, instance in enumerate(Schema.CONTACT_INSTANCES):
        if not has_api(prim, instance) or not codes:
            continue
        names = (Contact.STRIKE_TIMES[side], Contact.FLAT_TIMES[side], Contact.LIFTOFF_TIMES[side])
        times = [np.array([float(code) for code in authored(prim, name) or ()]) for name in names]
        counts = [len(values) for values in times] + [len(authored(prim, Contact.POSITIONS[side]) or ())]
        if len(set(counts)) > 1:
            what = f"the {SIDES[side]} foot has {', '.join(map(str, counts))} strikes, flats, liftoffs and positions"
            remedy = "author one of each a contact"
            found.append(finding("ContactArrayLength", prim, what, attribute=names[0], remedy=remedy))
            continue
        found += _contact_findings(prim, side, times, (codes[0], codes[-1]))
    return found


def animation_of(agent: Usd.Prim) -> tuple[Usd.Prim, Usd.Prim] | None:
    """An agent's Skeleton and the SkelAnimation bound to it; None if it has not both."""
    try:
        skeleton = find_skeleton(agent)
    except SkeletonError:
        return None
    animation = UsdSkel.BindingAPI(skeleton).GetInheritedAnimationSource()
    return (skeleton, animation) if animation else None


def _contact_findings(prim: Usd.Prim, side: int, times: list[FloatArray], ends: tuple[float, float]) -> list[Any]:
    """At most one contact of a foot out of order and one outside the animation."""
    disordered, outside = contact_faults(*times, first=ends[0], last=ends[1])
    found = []
    for name, faulty, remedy in (
        (
            "ContactOrder",
            disordered,
            "flat must follow strike, liftoff flat, and a strike the liftoff before",
        ),
        ("ContactOutside", outside, f"contacts must lie within the samples, from {ends[0]:g} to {ends[1]:g}"),
    ):
        if faulty.any():
            first = int(np.argmax(faulty))
            strike, flat, liftoff = (float(values[first]) for values in times)
            what = f"contact {first} of the {SIDES[side]} foot strikes at {strike:g}, is flat at {flat:g} and "
            what += f"lifts off at {liftoff:g}"
            found.append(finding(name, prim, what, attribute=Contact.STRIKE_TIMES[side], remedy=remedy))
    return found


def _check_skeleton(prim: Usd.Prim) -> list[Any]:
    """The joints of an agent's animation must be its Skeleton's."""
    bound = animation_of(prim) if has_api(prim, Schema.AGENT) else None
    if bound is None or not _is_ours(bound[1]):
        return []
    skeleton, animation = bound
    known = set(UsdSkel.Skeleton(skeleton).GetJointsAttr().Get() or ())
    unknown = [str(joint) for joint in authored(animation, "joints") or () if joint not in known]
    if not unknown:
        return []
    what = f"its animation {animation.GetPath()} moves {', '.join(unknown[:10])}, no joint of {skeleton.GetPath()}"
    return [finding("UnknownJoints", prim, what, remedy="name joints as Skeleton.joints does")]


def _samples_of(attribute: Usd.Attribute, time_range: Any) -> list[Usd.TimeCode]:
    """Time codes of an attribute's samples that are to be validated; its default where it has no samples."""
    codes = attribute.GetTimeSamples()
    if not codes:
        return [Usd.TimeCode.Default()] if attribute.HasAuthoredValue() else []
    return [Usd.TimeCode(code) for code in codes if time_range.GetInterval().Contains(code)]


def _is_ours(prim: Usd.Prim) -> bool:
    """Whether a SkelAnimation was written for usdfoot: it has contacts, or says how to use it as a clip."""
    return bool({Schema.CLIP, *Schema.CONTACT_INSTANCES} & set(applied_apis(prim)))


def _at(code: Usd.TimeCode) -> str:
    return "" if code.IsDefault() else f" at time code {code.GetValue():g}"
