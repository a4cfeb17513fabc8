"""DICOM by pydicom: series in sub-folders, time points, gaps, a tilted gantry, rescaling, frames in groups."""
import numpy as np
import pydicom
from cases import FOLDER, case, voxels
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.sequence import Sequence
from pydicom.uid import ExplicitVRLittleEndian, ImplicitVRLittleEndian

PIXEL = (0.5, 0.75)  # x, y
CT, ENHANCED = "1.2.840.10008.5.1.4.1.1.2", "1.2.840.10008.5.1.4.1.1.2.1"


def image(pixels, instance, series="1.2.826.0.1.3680043.10.1", syntax=ExplicitVRLittleEndian, kind=CT):
    """An image of int16 pixels[y, x] or frames[z, y, x], nowhere yet."""
    one = Dataset()
    one.file_meta = FileMetaDataset()
    one.file_meta.TransferSyntaxUID = syntax
    one.SOPClassUID = one.file_meta.MediaStorageSOPClassUID = kind
    one.SOPInstanceUID = one.file_meta.MediaStorageSOPInstanceUID = f"{series}.{instance}"
    one.StudyInstanceUID, one.SeriesInstanceUID, one.FrameOfReferenceUID = "1.2.826.1", series, "1.2.826.2"
    one.Modality, one.InstanceNumber = "CT", instance
    one.PatientName, one.PatientID = "Test", "1"
    one.SamplesPerPixel, one.PhotometricInterpretation = 1, "MONOCHROME2"
    one.Rows, one.Columns = pixels.shape[-2:]
    one.BitsAllocated = one.BitsStored = 16
    one.HighBit, one.PixelRepresentation = 15, 1
    one.PixelData = pixels.astype("<i2").tobytes()
    return one


def put(one, position):
    one.ImagePositionPatient = [float(p) for p in position]
    one.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
    one.PixelSpacing = [PIXEL[1], PIXEL[0]]
    one.RescaleSlope, one.RescaleIntercept = 1, 0
    return one


def save(one, *path):
    file = FOLDER.joinpath(*path)
    file.parent.mkdir(parents=True, exist_ok=True)
    one.save_as(file, enforce_file_format=True)


def write_series(folder, volume, positions, series="1.2.826.0.1.3680043.10.1", first=1, change=lambda one: None, **how):
    """Slices of volume[z, y, x]; the files' names run against their order in space."""
    for z, (pixels, position) in enumerate(zip(volume, positions)):
        one = put(image(pixels, first + z, series, **how), position)
        change(one)
        save(one, folder, f"IM{1000 - first - z:04}")


def stack(name, folder, expected, z=2.0, **what):
    wanted = {"spacing": [*PIXEL, z], "origin": [-10, -20, 30], "unit": "mm", "world": "patient",
              "direction": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}
    case(name, folder, expected, **{**wanted, **what})


def along_z(count, step=2.0):
    return [(-10, -20, 30 + step * k) for k in range(count)]


def in_sub_folders():
    scout, lung = voxels("int16", (2, 5, 7), 3), voxels("int16")

    def described(text, number):
        def change(one):
            one.SeriesDescription, one.SeriesNumber = text, number
        return change

    for name in ("dicom_longest", "dicom_by_number", "dicom_by_description", "dicom_by_uid"):
        write_series(f"{name}/scout", scout, along_z(2), "1.2.826.0.1.3680043.10.44.1", change=described("Scout", 1))
        write_series(f"{name}/a/b/lung", lung, along_z(6), "1.2.826.0.1.3680043.10.55.2",
                     change=described("Lung 1.0 B70f", 2))
    stack("dicom_longest", "dicom_longest", lung)
    stack("dicom_by_number", "dicom_by_number", scout, series="1")
    stack("dicom_by_description", "dicom_by_description", lung, series="lung 1.0 b70f")
    stack("dicom_by_uid", "dicom_by_uid", scout, series="44.1")


def time_points():
    times = [voxels("int16", seed=1 + 9 * t) for t in range(3)]
    kinds = {"position": lambda one, t: setattr(one, "TemporalPositionIdentifier", t + 1),
             "trigger": lambda one, t: setattr(one, "TriggerTime", 250 * t + 10),
             "acquisition": lambda one, t: setattr(one, "AcquisitionNumber", t + 8),
             "clock": lambda one, t: setattr(one, "AcquisitionTime", f"{9 + t // 2:02}59{10 + t}.25"),
             "echo": lambda one, t: setattr(one, "EchoTime", 4.5 + t)}
    for kind, tell in kinds.items():
        for frame in (None, 2):
            name = f"dicom_time_{kind}_{frame or 0}"
            for t in (1, 2, 0):
                write_series(name, times[t], along_z(6), first=1 + 6 * ((t + 1) % 3), change=lambda one: tell(one, t))
            stack(name, name, times[frame or 0], frames=3, frame=frame)


def gaps():
    whole = voxels("int16", (8, 5, 7))
    kept = [0, 1, 3, 4, 6, 7]
    write_series("dicom_gaps", whole[kept], [along_z(8)[k] for k in kept])
    filled = whole.copy()
    for z in (2, 5):
        filled[z] = np.rint((whole[z - 1].astype(float) + whole[z + 1]) / 2)
    stack("dicom_gaps", "dicom_gaps", filled)


def frames():
    """An enhanced image whose frames are in no order, at two times."""
    times = [voxels("int16", seed=1 + 9 * t) for t in range(2)]
    order = [(t, z) for z in (3, 1, 5, 0, 4, 2) for t in (1, 0)]
    one = image(np.array([times[t][z] for t, z in order]), 1, kind=ENHANCED)
    one.NumberOfFrames = len(order)
    shared = Dataset()
    orientation, measures = Dataset(), Dataset()
    orientation.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
    measures.PixelSpacing = [PIXEL[1], PIXEL[0]]
    shared.PlaneOrientationSequence, shared.PixelMeasuresSequence = Sequence([orientation]), Sequence([measures])
    one.SharedFunctionalGroupsSequence = Sequence([shared])
    groups = []
    for t, z in order:
        group, place, content = Dataset(), Dataset(), Dataset()
        place.ImagePositionPatient = list(along_z(6)[z])
        content.TemporalPositionIndex = t + 1
        group.PlanePositionSequence, group.FrameContentSequence = Sequence([place]), Sequence([content])
        groups.append(group)
    one.PerFrameFunctionalGroupsSequence = Sequence(groups)
    for t in range(2):
        name = f"dicom_frames_{t}"
        save(one, f"{name}.dcm")
        stack(name, f"{name}.dcm", times[t], frames=2, frame=t)


volume = voxels("int16")
write_series("dicom_explicit", volume, along_z(6))
stack("dicom_explicit", "dicom_explicit", volume)
write_series("dicom_implicit", volume, along_z(6), syntax=ImplicitVRLittleEndian)
stack("dicom_implicit", "dicom_implicit", volume)
write_series("dicom_tilted", volume, [(-10, -20 + 1.5 * k, 30 + 2 * k) for k in range(6)])
stack("dicom_tilted", "dicom_tilted", volume, z=2.5, direction=[[1, 0, 0], [0, 1, 0], [0, 0.6, 0.8]])
in_sub_folders()
time_points()
gaps()
frames()
