"""ReSTIR PT guided by the incident radiance alone: what it selected, divided by BSDF and cosine, instead of their
product.

Tests the remark of Zeng et al. 2025, section 4.2, that learning the product serves glossy surfaces better.
"""

from pipeline import pipeline

graph = pipeline("Radiance guided", train="selected", splat={"incident": True}, fit={"cosine": True})
