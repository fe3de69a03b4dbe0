"""The forms of a source, as a user writes them; nothing else is imported for a help text."""

GRAMMAR: tuple[tuple[str, str], ...] = (
    ("FILE.png", "one picture, valid at every moment (PNG, JPEG, BMP, TIFF, WebP)"),
    ("FOLDER", "its pictures, in natural order of their names, or by the times that all names are"),
    ("PATTERN", "the pictures that a pattern with *, ? or [] matches, likewise; ** for folders within"),
    ("VIDEO.mp4", "a video file, with the time stamps in it"),
    ("BAG#/topic", "a topic of a bag: FILE.mcap, FILE.db3, a folder with metadata.yaml, or ROS 1's FILE.bag"),
    ("camera:N", "camera number N; also N alone"),
    ("rtsp://HOST/PATH", "a stream; also rtsps, http, https, rtmp and udp"),
)
"""What `open_source` reads: a form, and what it stands for."""
SCHEMES = ("http", "https", "rtmp", "rtsp", "rtsps", "udp")
VIDEOS = frozenset(
    {
        ".3gp", ".asf", ".avi", ".flv", ".h264", ".h265", ".m2ts", ".m4v", ".mjpeg", ".mjpg", ".mkv", ".mov",
        ".mp4", ".mpeg", ".mpg", ".mts", ".ogv", ".ts", ".webm", ".wmv",
    }
)  # fmt: skip
"""Suffixes, in lower case, of the files that are read as videos: FFmpeg would take a text for one."""
