"""Texts of the interface in other languages.

Keys are the English texts of the source. Placeholders stay as they are: texts are translated
before they are filled in. Messages of the numeric core are English only.
"""

from __future__ import annotations

import bpy

GERMAN = {
    # Operators and panels
    "Adaptive Fairing": "Adaptives Glätten",
    "Animate": "Animieren",
    "Clear Animation": "Animation entfernen",
    "Compare with Uniform": "Mit gleichmäßig vergleichen",
    "Loop Subdivide (Limit Surface)": "Loop-Unterteilung (Grenzfläche)",
    "Measure Mesh": "Netz ausmessen",
    "Add Fairing Preset": "Glättungsvorgabe hinzufügen",
    "Stop": "Anhalten",
    "Suggest τ": "τ vorschlagen",
    "Select Problem Vertices": "Problempunkte auswählen",
    "Show Fairing Field": "Feld der Glättung zeigen",
    "Back to Shading": "Zurück zur Schattierung",
    "Density": "Dichte",
    "Region and Boundary": "Bereich und Rand",
    "Result": "Ergebnis",
    "Results": "Ergebnisse",
    "Stopping and Accuracy": "Abbruch und Genauigkeit",
    "Fairing Presets": "Glättungsvorgaben",
    "Colors": "Farben",
    "Comparison": "Vergleich",
    # Loop subdivision
    "Refine the selected meshes by Loop subdivision of their triangles, with all shape keys, UV "
    "maps, attributes and vertex groups. A mesh that other objects use as well stays as it is, and "
    "the object gets its own": "Die gewählten Netze durch Loop-Unterteilung ihrer Dreiecke "
    "verfeinern, mit allen Formschlüsseln, UV-Maps, Attributen und Vertexgruppen. Ein Netz, das "
    "auch andere Objekte benutzen, bleibt, wie es ist, und das Objekt bekommt ein eigenes",
    "Levels": "Stufen",
    "Number of steps; each cuts every triangle into four": "Anzahl der Schritte; jeder teilt jedes "
    "Dreieck in vier",
    "Limit Points": "Grenzpunkte",
    "Put the vertices on the smooth surface that further subdivision would lead to. Without it "
    "they are the control points of the finer mesh, to subdivide again": "Die Punkte auf die "
    "glatte Fläche setzen, zu der weitere Unterteilung führen würde. Sonst sind sie die "
    "Kontrollpunkte des feineren Netzes, das sich weiter unterteilen lässt",
    "Sharp Edges as Creases": "Scharfe Kanten als Falten",
    "Edges that are marked sharp or have a crease of 1 stay sharp, and vertices with a crease of 1 "
    "stay in place": "Kanten, die als scharf markiert sind oder eine Falte von 1 haben, bleiben "
    "scharf, und Punkte mit einer Falte von 1 bleiben am Ort",
    "Exact Normals": "Genaue Normalen",
    "Shade with the normals of the smooth surface, as custom normals. Clear them before you change "
    "the shape by hand": "Mit den Normalen der glatten Fläche schattieren, als eigene Normalen. "
    "Vor Änderungen der Form von Hand zu löschen",
    "Refined to {:d} triangles": "Verfeinert auf {:d} Dreiecke",
    "The object is linked from another file: make it local first": "Das Objekt ist aus einer "
    "anderen Datei verknüpft: erst lokal machen",
    # Surface of a result
    "Surface": "Fläche",
    "Choose the mesh that shows the result. Strength, Evolution, painting and the animation work "
    "on each of them, and Discard brings the original mesh back": "Das Netz wählen, das das "
    "Ergebnis zeigt. Stärke, Verlauf, Malen und Animation gehen auf jedem, und Verwerfen bringt "
    "das ursprüngliche Netz zurück",
    "The mesh that shows the result": "Das Netz, das das Ergebnis zeigt",
    "Control Mesh": "Kontrollnetz",
    "The mesh itself, as it was denoised": "Das Netz selbst, wie es entrauscht wurde",
    "Its vertices on the smooth surface that it stands for": "Seine Punkte auf der glatten "
    "Fläche, für die es steht",
    "Refined 1": "Verfeinert 1",
    "Refined 2": "Verfeinert 2",
    "Refined 3": "Verfeinert 3",
    "Each triangle in 4, with all vertices on the smooth surface": "Jedes Dreieck in 4, alle "
    "Punkte auf der glatten Fläche",
    "Each triangle in 16, with all vertices on the smooth surface": "Jedes Dreieck in 16, alle "
    "Punkte auf der glatten Fläche",
    "Each triangle in 64, with all vertices on the smooth surface": "Jedes Dreieck in 64, alle "
    "Punkte auf der glatten Fläche",
    "The refined mesh was changed by hand: it stays in the file as {!r}": "Das verfeinerte Netz "
    "wurde von Hand geändert: es bleibt als {!r} in der Datei",
    "Hold Sharp Edges": "Scharfe Kanten halten",
    "Vertices of edges that are marked sharp stay where they are": "Punkte von Kanten, die als "
    "scharf markiert sind, bleiben, wo sie sind",
    # Tooltips of operators
    "Select, in Edit Mode, the vertices of the active mesh that are not finite, not manifold or at "
    "triangles without area: what a run refuses, holds still or bounds": "Im Bearbeitungsmodus die "
    "Punkte des aktiven Netzes auswählen, die nicht endlich, nicht mannigfaltig oder an Dreiecken "
    "ohne Fläche sind: was ein Lauf ablehnt, festhält oder begrenzt",
    "Smooth the noise out of the selected meshes by geometric diffusion that follows the density "
    "of the mesh, and keep every step or strength": "Rauschen der gewählten Netze durch "
    "geometrische Diffusion glätten, die der Dichte des Netzes folgt, und jeden Schritt oder jede "
    "Stärke behalten",
    "Let the timeline run through the evolution of the active object": "Die Zeitleiste durch den "
    "Verlauf des aktiven Objekts laufen lassen",
    "Take the evolution of the active object off the timeline": "Den Verlauf des aktiven Objekts "
    "von der Zeitleiste nehmen",
    "Fair two copies of the active mesh, one uniformly and one adaptively, and lay them side by "
    "side with labels": "Zwei Kopien des aktiven Netzes glätten, eine gleichmäßig, eine adaptiv, "
    "und beschriftet nebeneinander legen",
    "Find out what τ means on the active mesh, anew if it was known": "Herausfinden, was τ auf "
    "dem aktiven Netz bedeutet, auch wenn es schon bekannt war",
    "Add a preset with the settings of the panel, or remove one": "Eine Vorgabe mit den "
    "Einstellungen der Leiste hinzufügen oder eine entfernen",
    "Stop the run after the step it is computing and keep the finished steps; an automatic run "
    "stops at once, without a result": "Den Lauf nach dem Schritt anhalten, der gerade gerechnet "
    "wird, und die fertigen Schritte behalten; ein automatischer Lauf hält sofort an, ohne "
    "Ergebnis",
    "Set τ so that all steps together smooth over the wanted radius in a typical part of the "
    "active mesh": "τ so setzen, dass alle Schritte zusammen an typischen Stellen des aktiven "
    "Netzes über den gewünschten Radius glätten",
    "Colour the selected meshes, as they are shown now, by a field": "Die gewählten Netze, wie "
    "sie gerade gezeigt werden, nach einem Feld einfärben",
    "Show the 3D view as it was before the colours": "Die 3D-Ansicht zeigen wie vor den Farben",
    # Settings of the solver
    "Method": "Verfahren",
    "How the smoothing follows the density of the mesh": "Wie die Glättung der Dichte des Netzes "
    "folgt",
    "Automatic": "Automatisch",
    "Estimate the noise and remove it, without parameters": "Das Rauschen schätzen und entfernen, "
    "ohne Parameter",
    "Strength": "Stärke",
    "Factor of the noise that is estimated: more if noise is left, less if details go": "Faktor "
    "des geschätzten Rauschens: mehr, wenn Rauschen bleibt, weniger, wenn Einzelheiten "
    "verschwinden",
    "Edges": "Kanten",
    "Whether the smoothing keeps sharp edges": "Ob die Glättung scharfe Kanten erhält",
    "Decide in every part of the mesh what fits better": "In jedem Teil des Netzes entscheiden, "
    "was besser passt",
    "Keep Sharp": "Scharf lassen",
    "The mesh has sharp edges, which stay where they can": "Das Netz hat scharfe Kanten, die "
    "möglichst bleiben",
    "Smooth": "Glatt",
    "The mesh has no sharp edges: what looks like one is noise": "Das Netz hat keine scharfen "
    "Kanten: was so aussieht, ist Rauschen",
    "Adaptive Timestep": "Adaptiver Zeitschritt",
    "Coarse parts run through more time than dense ones: details in dense parts stay": "Grobe "
    "Stellen durchlaufen mehr Zeit als dichte: Einzelheiten an dichten Stellen bleiben",
    "Adaptive Tensor": "Adaptiver Tensor",
    "The same time everywhere, but dense parts conduct less": "Überall dieselbe Zeit, aber dichte "
    "Stellen leiten schlechter",
    "Uniform": "Gleichmäßig",
    "The same smoothing everywhere, whatever the density; needs a much smaller τ": "Überall "
    "dieselbe Glättung, wie dicht das Netz auch ist; braucht ein viel kleineres τ",
    "τ": "τ",
    "Time of one step, with the mesh scaled to the box [-3, 3]³: larger values smooth over larger "
    "distances": "Zeit eines Schritts, wobei das Netz auf den Würfel [-3, 3]³ gebracht ist: "
    "größere Werte glätten über größere Entfernungen",
    "Steps": "Schritte",
    "How many steps to take; each one is kept": "Wie viele Schritte; jeder wird behalten",
    "Measure": "Maß",
    "What the density of the mesh is measured by": "Woran die Dichte des Netzes gemessen wird",
    "Edge Length": "Kantenlänge",
    "Mean length of the edges at a vertex": "Mittlere Länge der Kanten an einem Punkt",
    "Area": "Fläche",
    "Area of the triangles around a vertex; the smoothing radius is then the same number of edges "
    "everywhere": "Fläche der Dreiecke um einen Punkt; der Glättungsradius ist dann überall "
    "dieselbe Zahl von Kanten",
    "Smoothing Passes": "Glättungen",
    "How often the measured density is smoothed before it is used": "Wie oft die gemessene Dichte "
    "geglättet wird, bevor sie benutzt wird",
    "Boundary": "Rand",
    "What happens to the rim of an open mesh": "Was mit dem Rand eines offenen Netzes geschieht",
    "Fixed": "Fest",
    "Boundary vertices stay exactly where they are": "Randpunkte bleiben genau, wo sie sind",
    "Free": "Frei",
    "The boundary is smoothed along with the surface, and may shrink": "Der Rand wird mit der "
    "Fläche geglättet und kann schrumpfen",
    "Curvature Left": "Restkrümmung",
    "Stop once this part of the bending (curvature energy H) is left; 0 takes every step": "Ende, "
    "sobald nur dieser Anteil der Biegung (Krümmungsenergie H) übrig ist; 0 macht jeden Schritt",
    "Rate": "Rate",
    "Stop once the part of the bending changes by less than this per unit of time; 0 takes every "
    "step": "Enden, sobald sich der Anteil der Biegung je Zeiteinheit um weniger ändert; 0 macht "
    "jeden Schritt",
    "Solver Tolerance": "Toleranz des Lösers",
    "Relative residual at which the linear system of a step counts as solved": "Relatives "
    "Residuum, bei dem das lineare System eines Schritts als gelöst gilt",
    "Solver Iterations": "Iterationen des Lösers",
    "Give up a step after this many iterations of the linear solver": "Einen Schritt nach so "
    "vielen Iterationen des linearen Lösers aufgeben",
    "Integration Tolerance": "Toleranz der Integration",
    "Error of the integrals over the surface, relative to the largest": "Fehler der Integrale "
    "über die Fläche, bezogen auf das größte",
    "Scale to Box": "Auf Würfel bringen",
    "Scale the mesh to the box [-3, 3]³ for the solver, so that τ does not depend on its size; "
    "otherwise τ is in squared object units": "Das Netz für den Löser auf den Würfel [-3, 3]³ "
    "bringen, damit τ nicht von seiner Größe abhängt; sonst gilt τ in quadrierten Objekteinheiten",
    # Region and result
    "Selection or Mask": "Auswahl oder Maske",
    "In Edit Mode smooth the selected vertices only, if any are selected; in Sculpt Mode spare the "
    "masked ones": "Im Bearbeitungsmodus nur die gewählten Punkte glätten, falls welche gewählt "
    "sind; im Bildhauermodus die maskierten verschonen",
    "Vertex Group": "Scheitelpunktgruppe",
    "Smooth by the weights of this group; empty for the whole mesh": "Nach den Gewichten dieser "
    "Gruppe glätten; leer für das ganze Netz",
    "Invert": "Umkehren",
    "Smooth where the weights of the group are small instead": "Statt dessen dort glätten, wo die "
    "Gewichte der Gruppe klein sind",
    "What the object gets": "Was das Objekt bekommt",
    "Evolution": "Verlauf",
    "Every step, or strength, as an absolute shape key: one slider runs through them": "Jeder "
    "Schritt oder jede Stärke als absolute Form: ein Regler läuft durch sie",
    "Relative Shape Keys": "Relative Formen",
    "Every step, or strength, as a relative shape key, which exporters understand": "Jeder "
    "Schritt oder jede Stärke als relative Form, die Exporter verstehen",
    "Final Shape Only": "Nur Endform",
    "Move the vertices; no shape keys": "Die Punkte bewegen; keine Formen",
    "Other Shape Keys": "Andere Formen",
    "What to do with an object that has shape keys of its own": "Was mit einem Objekt geschieht, "
    "das eigene Formen hat",
    "Work on a Copy": "Kopie bearbeiten",
    "Leave the object as it is, hide it, and fair a copy": "Das Objekt lassen, wie es ist, es "
    "verbergen und eine Kopie glätten",
    "Refuse": "Ablehnen",
    "Leave the object as it is and say so": "Das Objekt lassen, wie es ist, und das sagen",
    "Density Attribute": "Dichte-Attribut",
    "Store the density of the last step as fairing_density and fairing_density_color": "Die "
    "Dichte des letzten Schritts als fairing_density und fairing_density_color speichern",
    "From Frame": "Von Bild",
    "Frame that shows the mesh before the first step": "Bild, das das Netz vor dem ersten Schritt "
    "zeigt",
    "To Frame": "Bis Bild",
    "Frame that shows the last step": "Bild, das den letzten Schritt zeigt",
    "Radius": "Radius",
    "Wanted smoothing radius in local edge lengths, all steps together: about 1 takes noise only, "
    "3 and more takes shapes of that size as well": "Gewünschter Glättungsradius in örtlichen "
    "Kantenlängen, alle Schritte zusammen: etwa 1 nimmt nur Rauschen, ab 3 gehen auch Formen "
    "dieser Größe",
    "Run through the smoothing: from the mesh before (0) to the last step, or to the largest "
    "strength (1)": "Durch die Glättung laufen: vom Netz davor (0) bis zum letzten Schritt oder "
    "zur größten Stärke (1)",
    "Uniform τ": "Gleichmäßiges τ",
    "τ of the uniform copy; 0 takes the mean of τ times density of the other": "τ der "
    "gleichmäßigen Kopie; 0 nimmt das Mittel von τ mal Dichte der anderen",
    # Colours
    "Field": "Feld",
    "What the colours mean": "Was die Farben bedeuten",
    "How coarse the mesh is: where it is bright, the adaptive methods smooth more": "Wie grob das "
    "Netz ist: wo es hell ist, glätten die adaptiven Verfahren mehr",
    "Displacement": "Versatz",
    "How far the smoothing has moved each vertex": "Wie weit die Glättung jeden Punkt bewegt hat",
    "Mean Curvature": "Mittlere Krümmung",
    "Mean curvature of the limit surface: red where it bulges outward, blue where "
    "inward": "Mittlere Krümmung der Grenzfläche: rot, wo sie sich nach außen wölbt, blau nach "
    "innen",
    "Gaussian Curvature": "Gaußsche Krümmung",
    "Gaussian curvature of the limit surface: red on bumps and in bowls, blue on saddles, near "
    "white where it bends in one direction only": "Gaußsche Krümmung der Grenzfläche: rot auf "
    "Buckeln und in Mulden, blau auf Sätteln, fast weiß, wo sie sich nur in eine Richtung biegt",
    "Removed": "Entfernt",
    "What the smoothing has removed, along the normals: red where it took a bump off, blue where "
    "it filled a dent; noise looks random, a shape that shows here was smoothed away": "Was die "
    "Glättung entfernt hat, längs der Normalen: rot, wo sie einen Buckel abgetragen, blau, wo sie "
    "eine Delle gefüllt hat; Rauschen sieht zufällig aus, eine Form, die hier erscheint, wurde "
    "weggeglättet",
    # Sequences
    "Frame Sequence": "Bildfolge",
    "Fair Frames": "Bilder glätten",
    "Fair the active object as it is shown at each frame of a range, modifiers and simulations "
    "included, and make a new object that plays the faired frames; bake simulations first": "Das "
    "aktive Objekt so glätten, wie es in jedem Bild eines Bereichs erscheint, mit Modifikatoren "
    "und Simulationen, und ein neues Objekt machen, das die geglätteten Bilder abspielt; "
    "Simulationen vorher backen",
    "First Frame": "Erstes Bild",
    "First frame to fair": "Erstes Bild, das geglättet wird",
    "Last Frame": "Letztes Bild",
    "Last frame to fair": "Letztes Bild, das geglättet wird",
    "Same Strength": "Gleiche Stärke",
    "Smooth every frame as the first one, so that nothing flickers": "Jedes Bild so glätten wie "
    "das erste, damit nichts flackert",
    "Fair {:d} Frames": "{:d} Bilder glätten",
    "Stop, Keep Frames": "Anhalten, Bilder behalten",
    "Frame {:d}": "Bild {:d}",
    "Faired {:d} frames, {:.1f} s": "{:d} Bilder geglättet, {:.1f} s",
    "Stopped before the first frame was done": "Angehalten, bevor das erste Bild fertig war",
    "there are no faces at frame {:d}": "in Bild {:d} gibt es keine Flächen",
    "the faces at frame {:d} are not those of frame {:d}": "die Flächen von Bild {:d} sind nicht "
    "die von Bild {:d}",
    "Change to Object Mode": "In den Objektmodus wechseln",
    # Panels
    "Smoothing Radius in Edges": "Glättungsradius in Kanten",
    "Densest": "Dichteste",
    "Typical": "Typisch",
    "Coarsest": "Gröbste",
    "Step": "Schritt",
    "Run": "Lauf",
    "Measuring…": "Wird gemessen …",
    "Not measured yet": "Noch nicht gemessen",
    "Fair": "Glätten",
    "Fair {:d} Objects": "{:d} Objekte glätten",
    "Stop at Curvature": "Enden bei Krümmung",
    "Stop at Rate": "Enden bei Rate",
    "Iterations": "Iterationen",
    "Integration": "Integration",
    "Stopping…": "Hält an …",
    "Stop, Keep Steps": "Anhalten, Schritte behalten",
    "Step {:d} of {:d}": "Schritt {:d} von {:d}",
    "Measuring the noise": "Rauschen wird gemessen",
    "Removing noise: {:.0f} %": "Rauschen entfernen: {:.0f} %",
    "{:d} solver iterations  ·  H at {:.1f} %": "{:d} Iterationen  ·  H bei {:.1f} %",
    "stopping": "hält an",
    "Esc: stop": "Esc: anhalten",
    "stopping after this step": "hält nach diesem Schritt an",
    "Esc: stop, keep the finished steps": "Esc: anhalten, fertige Schritte behalten",
    "Step {:.1f} of {:d}": "Schritt {:.1f} von {:d}",
    "Strength {:.2f}": "Stärke {:.2f}",
    "Chosen": "Gewählt",
    "{:d} of {:d}, strength {:.4g}": "{:d} von {:d}, Stärke {:.4g}",
    "Noise": "Rauschen",
    "Noise found": "Rauschen",
    "{:.3g} edges  ·  {:s}": "{:.3g} Kanten  ·  {:s}",
    "Radius used": "Radius",
    "{:.2f} edges": "{:.2f} Kanten",
    "Treated as": "Behandelt als",
    "Sharp": "Scharf",
    "Time": "Zeit",
    "Start": "Start",
    "End": "Ende",
    "Animate over Frames": "Über Bilder animieren",
    "Curvature H": "Krümmung H",
    "Before  {:.4g}": "Davor  {:.4g}",
    "After  {:.4g}": "Danach  {:.4g}",
    "{:.1f} % left": "noch {:.1f} %",
    "{:.2f} s, {:d} iterations": "{:.2f} s, {:d} Iterationen",
    "Ended by": "Ende",
    "Volume": "Volumen",
    "Largest move": "Größter Weg",
    "All steps done": "Alle Schritte gemacht",
    "Curvature low enough": "Krümmung klein genug",
    "Hardly any change left": "Kaum noch Änderung",
    "Stopped by hand": "Von Hand angehalten",
    "Before": "Davor",
    "Adaptive": "Adaptiv",
    "Fairing Comparison": "Glättungsvergleich",
    # Results
    "Advanced": "Erweitert",
    "Animation": "Animation",
    "Apply": "Anwenden",
    "Denoise": "Entrauschen",
    "Diffuse": "Diffundieren",
    "Discard": "Verwerfen",
    "From Original": "Vom Original",
    "Hide Colors": "Farben ausblenden",
    "Live": "Direkt",
    "Modifier": "Modifikator",
    "Options": "Optionen",
    "Paint Back": "Zurückmalen",
    "Split": "Teilen",
    "Statistics": "Statistik",
    "Steps As": "Schritte als",
    "Bring the mesh back to exactly what it was before the runs": (
        "Das Netz genau auf den Stand vor den Läufen zurückbringen"
    ),
    "Change to Weight Paint with the vertex group Fairing: weight 0 brings the original "
    "back, 1 shows the result; once more leaves it": (
        "In die Gewichtsmalerei mit der Scheitelpunktgruppe Fairing wechseln: Gewicht 0 bringt "
        "das Original zurück, 1 zeigt das Ergebnis; noch einmal verlässt sie"
    ),
    "Curvature Energy H": "Krümmungsenergie H",
    "Every step as a relative shape key": "Jeder Schritt als relative Form",
    "Every step as an absolute shape key: one slider runs through them": (
        "Jeder Schritt als absolute Form: ein Regler läuft durch sie"
    ),
    "Keep the shape as it is shown and remove everything else that the runs have left: "
    "stored shapes, shape keys, modifier, colors": (
        "Die gezeigte Form behalten und alles andere entfernen, was die Läufe hinterlassen "
        "haben: gespeicherte Formen, Formschlüssel, Modifikator, Farben"
    ),
    "Leave Edit Mode to change the strength": (
        "Den Bearbeitungsmodus verlassen, um die Stärke zu ändern"
    ),
    "Noise {:s}": "Rauschen {:s}",
    "Paint with weight 0 to bring the original back": (
        "Mit Gewicht 0 malen, um das Original zurückzubringen"
    ),
    "Remove Comparison": "Vergleich entfernen",
    "Remove the colors of the view, and the numbers behind them, from all objects": (
        "Die Farben der Ansicht und die Zahlen dahinter von allen Objekten entfernen"
    ),
    "Remove the noise of the selected meshes, such as scans: estimate how much there is, or "
    "smooth by the geometric diffusion of the paper. Starts from the shape that is shown": (
        "Das Rauschen der gewählten Netze, etwa von Scans, entfernen: schätzen, wie viel da ist, "
        "oder durch die geometrische Diffusion der Arbeit glätten. Beginnt mit der gezeigten Form"
    ),
    "Smooth the selected meshes by the paper's geometric diffusion, which follows the "
    "density of the mesh, and keep every step. Starts from the shape that is shown": (
        "Die gewählten Netze durch die geometrische Diffusion der Arbeit glätten, die der Dichte "
        "des Netzes folgt, und jeden Schritt behalten. Beginnt mit der gezeigten Form"
    ),
    "Shape keys have no weights to paint: use the result Live or Modifier": (
        "Formen haben keine Gewichte zum Malen: das Ergebnis Direkt oder Modifikator nehmen"
    ),
    "Show the original as long as the key is held; the button shows it until the next click": (
        "Das Original zeigen, solange die Taste gedrückt ist; der Knopf zeigt es bis zum "
        "nächsten Klick"
    ),
    "Show the original on the left half of the object, as it is seen now, and the result on "
    "the right; once more shows the whole result": (
        "Auf der linken Hälfte des Objekts, wie es jetzt zu sehen ist, das Original zeigen und "
        "rechts das Ergebnis; noch einmal zeigt das ganze Ergebnis"
    ),
    "Split works with the result Live": "Teilen geht mit dem Ergebnis Direkt",
    "Start from the shape before the first run, and discard what the runs have done since; "
    "otherwise start from the shape that is shown": (
        "Mit der Form vor dem ersten Lauf beginnen und verwerfen, was die Läufe seither getan "
        "haben; sonst mit der gezeigten Form beginnen"
    ),
    "Step {:d}": "Schritt {:d}",
    "Store the density of the mesh as fairing_density and fairing_density_color; the paper's "
    "methods always do": (
        "Die Dichte des Netzes als fairing_density und fairing_density_color speichern; die "
        "Verfahren der Arbeit tun es immer"
    ),
    "The mesh itself has the shape that is shown, so every exporter writes it; the original "
    "and the offsets are kept as attributes for the Strength slider": (
        "Das Netz selbst hat die gezeigte Form, also schreibt sie jeder Exporter; Original und "
        "Versätze bleiben als Attribute für den Regler Stärke"
    ),
    "The mesh stays as it is; the modifier Adaptive Fairing shows the result": (
        "Das Netz bleibt, wie es ist; der Modifikator Adaptive Fairing zeigt das Ergebnis"
    ),
    "The mesh was changed since the last run. The next one starts from what is shown": (
        "Das Netz wurde seit dem letzten Lauf geändert. Der nächste beginnt mit dem, was zu "
        "sehen ist"
    ),
    "The mesh was changed since the last run: its stored result does not fit any more": (
        "Das Netz wurde seit dem letzten Lauf geändert: das gespeicherte Ergebnis passt nicht mehr"
    ),
    "smoothed {:.2g} edges": "geglättet {:.2g} Kanten",
    "the shape before the smoothing was not kept": (
        "die Form vor dem Glätten wurde nicht aufgehoben"
    ),
    "there is no result on this object": "auf diesem Objekt ist kein Ergebnis",
    "volume {:s}": "Volumen {:s}",
    "{:.4g} in the box [-3, 3]³": "{:.4g} im Würfel [-3, 3]³",
    "unit": "Einheit",
    "{:d} steps": "{:d} Schritte",
    "{:s} has a mesh of its own now: other objects keep the old one": (
        "{:s} hat jetzt ein eigenes Netz: andere Objekte behalten das alte"
    ),
    "{:s} {:d} Objects": "{:s}: {:d} Objekte",
    "{:s}: the mesh was changed since the last run, whose stored result was dropped": (
        "{:s}: das Netz wurde seit dem letzten Lauf geändert, dessen gespeichertes Ergebnis "
        "entfällt"
    ),
    "The active object has no result of Adaptive Fairing that can still be changed": (
        "Das aktive Objekt hat kein Ergebnis von Adaptive Fairing, das noch zu ändern ist"
    ),
    "Only a result with a slider can be compared with the original": (
        "Nur ein Ergebnis mit einem Regler kann mit dem Original verglichen werden"
    ),
    "How much of the noise is removed: 0 is the original, 1 what was estimated; works in "
    "real time": (
        "Wie viel vom Rauschen entfernt wird: 0 ist das Original, 1 was geschätzt wurde; wirkt "
        "sofort"
    ),
    "Run through the smoothing: from the mesh before (0) to the last step (1)": (
        "Durch die Glättung laufen: vom Netz davor (0) bis zum letzten Schritt (1)"
    ),
    "The result goes to a copy; this object is hidden": (
        "Das Ergebnis kommt auf eine Kopie; dieses Objekt wird verborgen"
    ),
    "Other objects share this mesh: they keep the old one": (
        "Andere Objekte teilen dieses Netz: sie behalten das alte"
    ),
    "Multiresolution: the base mesh is smoothed, not the sculpted levels": (
        "Mehrfachauflösung: das Grundnetz wird geglättet, nicht die geformten Stufen"
    ),
    "Modifiers stay above: the mesh below them is smoothed": (
        "Modifikatoren bleiben darüber: das Netz darunter wird geglättet"
    ),
    "The scale is not uniform: apply it first": "Die Skalierung ist ungleich: erst anwenden",
    "From Original: what the runs have done since is discarded": (
        "Vom Original: was die Läufe seither getan haben, wird verworfen"
    ),
    "Diffusion (paper)": "Diffusion (Arbeit)",
    ", {:.0f} s left": ", noch {:.0f} s",
    "Denoise Scan (Fair, Smooth Noise)": "Scan entrauschen (Rauschen glätten)",
    "Diffuse (Fair, Smooth by the Paper)": "Diffundieren (Glätten nach der Arbeit)",
    "Clean Meshes": "Saubere Netze",
    "What happens to a mesh that looks like a model without noise": "Was mit einem Netz geschieht, "
    "das wie ein Modell ohne Rauschen aussieht",
    "Leave Alone": "In Ruhe lassen",
    "Change nothing, and say why": "Nichts ändern und sagen, warum",
    "Take all that is rough for noise": "Alles Raue für Rauschen nehmen",
    "The animation of the evolution is removed with its shape keys": "Die Animation des Verlaufs "
    "entfällt mit seinen Formen",
    # Messages
    "Change to Object Mode, Edit Mode or Sculpt Mode": "In den Objekt-, Bearbeitungs- oder "
    "Bildhauermodus wechseln",
    "Turn off dynamic topology sculpting": "Dynamische Topologie ausschalten",
    "Leave Sculpt Mode: the mask of a multiresolution sculpture cannot be read": "Bildhauermodus "
    "verlassen: die Maske einer Mehrfachauflösung kann nicht gelesen werden",
    "Select a mesh object": "Ein Netzobjekt auswählen",
    "Make a mesh object active": "Ein Netzobjekt aktiv machen",
    "A run is going on: wait for it, or stop it with Esc": "Ein Lauf ist im Gang: abwarten oder "
    "mit Esc anhalten",
    "Fair the active object first, with Evolution as its result": "Zuerst das aktive Objekt "
    "glätten, mit Verlauf als Ergebnis",
    "The last frame must come after the first": "Das letzte Bild muss nach dem ersten kommen",
    "there is no vertex group {!r}": "es gibt keine Scheitelpunktgruppe {!r}",
    "selection, mask and vertex group leave no vertex to smooth": "Auswahl, Maske und "
    "Scheitelpunktgruppe lassen keinen Punkt zum Glätten übrig",
    "has shape keys of its own, or is linked from another file: allow to work on a copy, or make "
    "one without them": "hat eigene Formen oder ist aus einer anderen Datei verknüpft: Arbeit an "
    "einer Kopie erlauben oder eine Kopie ohne sie machen",
    "the object was deleted during the run": "das Objekt wurde während des Laufs gelöscht",
    "the mesh was changed during the run; nothing was written": "das Netz wurde während des Laufs "
    "geändert; nichts wurde geschrieben",
    "the shape before the smoothing was not kept: choose another Result than Final Shape Only to "
    "see this": "die Form vor dem Glätten wurde nicht aufgehoben: um dies zu sehen, ein anderes "
    "Ergebnis als Nur Endform wählen",
    "the mesh is linked from another file: make it local to colour it": "das Netz ist aus einer "
    "anderen Datei verknüpft: zum Einfärben lokal machen",
    "Denoised {:d} vertices, {:.1f} s": "{:d} Punkte entrauscht, {:.1f} s",
    "Faired {:d} vertices in {:d} steps, {:.1f} s": "{:d} Punkte in {:d} Schritten geglättet, "
    "{:.1f} s",
    "No problem vertices": "Keine Problempunkte",
    "Not finite: {:d}, held: {:d}, doubled: {:d}, without area: {:d}": "Nicht endlich: {:d}, "
    "festgehalten: {:d}, doppelt: {:d}, ohne Fläche: {:d}",
    "Change to Object Mode or Edit Mode": "In den Objekt- oder Bearbeitungsmodus wechseln",
    "The mesh is linked from another file: it cannot be edited here": "Das Netz ist aus einer "
    "anderen Datei verknüpft: es kann hier nicht bearbeitet werden",
    "Stopped early. {:s}": "Vorzeitig angehalten. {:s}",
    "Stopped: nothing was changed": "Angehalten: nichts wurde geändert",
    "Stopped before both copies were done": "Angehalten, bevor beide Kopien fertig waren",
    "τ = {:.4g}": "τ = {:.4g}",
}
"""German by English texts."""


def register() -> None:
    """Offer the translations to Blender."""
    texts = {
        (context, english): german
        for english, german in GERMAN.items()
        # Labels of operators have a context of their own.
        for context in ("*", bpy.app.translations.contexts.operator_default)
    }
    # Blender has named its German both ways.
    bpy.app.translations.register(__package__, {"de": texts, "de_DE": texts})


def unregister() -> None:
    """Withdraw the translations."""
    bpy.app.translations.unregister(__package__)
