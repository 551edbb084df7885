"""Path guiding in screen space after Derevyannykh 2022, inside ReSTIR PT: one lobe a pixel, fitted to the paths of the frames before."""

from pipeline import pipeline

graph = pipeline("Raw PT guiding, Derevyannykh 2022", train="raw", cells="screen")
