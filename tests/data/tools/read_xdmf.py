"""Opens an XDMF file with ParaView's reader and prints what it found as JSON: pvpython read_xdmf.py FILE"""

import json
import sys

from paraview import servermanager, simple

reader = simple.Xdmf3ReaderS(FileName=[sys.argv[1]])
reader.UpdatePipelineInformation()
steps = []
for time in reader.TimestepValues:
    reader.UpdatePipeline(time)
    information = reader.GetDataInformation()

    def arrays(attributes):
        found = {}
        for i in range(attributes.GetNumberOfArrays()):
            array = attributes.GetArrayInformation(i)
            ranges = [array.GetComponentRange(k) for k in range(array.GetNumberOfComponents())]
            found[array.GetName()] = [list(r) for r in ranges]
        return found

    steps.append({
        "time": time,
        "points": information.GetNumberOfPoints(),
        "cells": information.GetNumberOfCells(),
        "bounds": list(information.GetBounds()),
        "point_arrays": arrays(information.GetPointDataInformation()),
        "cell_arrays": arrays(information.GetCellDataInformation()),
    })
print(json.dumps({"steps": steps}))
